;;; eglot.el --- Emacs' eglot against the server -*- lexical-binding: t -*-
;; Run by `cargo xtask test'; Emacs 28 with eglot 1.9, and later.
;;
;;   DOTGEN=path/to/dotgen FILE=maneuver.gen emacs --batch -l eglot.el
;;
;; The mode is the one of editors/emacs.
;;
;; FILE is in a copy of examples/maneuver.  Exit status 0 or 1.

;;; Code:
(require 'package)
(package-initialize)
(require 'eglot)
(require 'flymake)
(require 'cl-lib)

(load (expand-file-name "../../../editors/emacs/genom3-mode.el" (file-name-directory load-file-name)) nil t)
(remove-hook 'genom3-mode-hook #'eglot-ensure)
(add-to-list 'eglot-server-programs (list 'genom3-mode (getenv "DOTGEN") "lsp"))
(setq debug-on-error nil
      eglot-sync-connect 20
      eglot-autoshutdown t)

(defun wait-for (what condition)
  "Wait until CONDITION returns non-nil; WHAT says what for."
  (let ((rounds 0))
    (while (and (not (funcall condition)) (< rounds 400))
      (accept-process-output nil 0.05)
      (setq rounds (1+ rounds)))
    (if (funcall condition)
        (message "ok %s" what)
      (message "FAIL timed out: %s" what)
      (kill-emacs 1))))

(defun flush ()
  "Tell the server about changes, which an idle timer does in a live Emacs."
  (eglot--signal-textDocument/didChange)
  (flymake-start))

(defun errors ()
  "Return the error diagnostics of the current buffer."
  (cl-remove-if-not
   (lambda (diagnostic) (memq (flymake-diagnostic-type diagnostic) '(eglot-error :error)))
   (flymake-diagnostics)))

(condition-case failure
    (with-current-buffer (find-file-noselect (getenv "FILE"))
      (call-interactively #'eglot)
      (wait-for "attached" #'eglot-current-server)
      (flymake-start)

      (goto-char (point-min))
      (search-forward "yield ether wcet 4 us;")
      (insert " oops")
      (flush)
      (wait-for "an error is reported" #'errors)
      (message "   %s" (flymake-diagnostic-text (car (errors))))

      (delete-char (- (length " oops")))
      (flush)
      (wait-for "the error is gone" (lambda () (null (errors))))

      (let ((names (flatten-tree (eglot-imenu))))
        (cl-assert (cl-some (lambda (name) (and (stringp name) (string-match-p "goto" name))) names) t)
        (message "ok imenu"))

      (goto-char (point-min))
      (search-forward "#include \"or/pose")
      (let ((found (xref-backend-definitions 'eglot (xref-backend-identifier-at-point 'eglot))))
        (cl-assert (= 1 (length found)) t)
        (message "ok definition of an include"))

      (search-forward "activity goto")
      (dotgen-diagram "fsm")
      (with-current-buffer "*dotgen diagram*"
        (cl-assert (string-match-p "\\`flowchart TD\n\\(.\\|\n\\)*mv_goto_plan" (buffer-string)) t)
        (message "ok picture as Mermaid"))

      (set-buffer-modified-p nil)
      (eglot-shutdown (eglot-current-server))
      (message "ok shutdown"))
  (error
   (message "FAIL %S" failure)
   (kill-emacs 1)))
;;; eglot.el ends here
