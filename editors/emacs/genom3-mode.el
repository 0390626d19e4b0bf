;;; genom3-mode.el --- GenoM3 specifications, with the server dotgen -*- lexical-binding: t -*-

;;; Code:
(require 'eglot)

(define-derived-mode genom3-mode prog-mode "GenoM3"
  "Mode for GenoM3 component specifications and their verification scenarios."
  (setq-local comment-start "// "
              comment-end ""
              indent-tabs-mode nil))
(modify-syntax-entry ?/ ". 124b" genom3-mode-syntax-table)
(modify-syntax-entry ?* ". 23" genom3-mode-syntax-table)
(modify-syntax-entry ?\n "> b" genom3-mode-syntax-table)
(modify-syntax-entry ?_ "_" genom3-mode-syntax-table)
(add-to-list 'auto-mode-alist '("\\.\\(gen\\|scn\\)\\'" . genom3-mode))

(add-to-list 'eglot-server-programs
             '(genom3-mode "dotgen" "lsp" :initializationOptions (:trusted t)))
(add-hook 'genom3-mode-hook #'eglot-ensure)

(defun dotgen-command (name argument)
  "Let the server execute the command NAME with ARGUMENT, and return the result."
  (jsonrpc-request (eglot-current-server) :workspace/executeCommand
                   (list :command name :arguments (vector argument))
                   :timeout 60))

(defun dotgen-generate ()
  "Run a template over this specification; the server asks for the template."
  (interactive)
  (dotgen-command "dotgen.generate" (eglot--TextDocumentIdentifier)))

(defun dotgen-diagram (kind)
  "Draw the machine at point as Mermaid; with a prefix argument, the whole system.
KIND is `fsm', `system' or `locks'."
  (interactive (list (if current-prefix-arg "system" "fsm")))
  (let ((text (dotgen-command "dotgen.diagram.mermaid"
                              (append (list :kind kind) (eglot--TextDocumentPositionParams)))))
    (unless text (user-error "There is nothing to draw here"))
    (with-current-buffer (get-buffer-create "*dotgen diagram*")
      (erase-buffer)
      (insert text)
      (display-buffer (current-buffer)))))

(provide 'genom3-mode)
;;; genom3-mode.el ends here
