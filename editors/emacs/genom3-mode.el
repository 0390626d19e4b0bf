;;; genom3-mode.el --- GenoM3 specifications, with the server dotgen -*- lexical-binding: t -*-

;;; Code:
(require 'eglot)
(require 'url-util)

(defconst genom3-font-lock
  `((,(regexp-opt '("int8" "int16" "int32" "int64" "uint8" "uint16" "uint32" "uint64" "short" "long"
                    "unsigned" "float" "double" "char" "octet" "boolean" "string" "any" "sequence"
                    "optional" "struct" "union" "enum" "typedef" "const" "native")
                  'symbols)
     . font-lock-type-face)
    (,(regexp-opt '("component" "interface" "module" "ids" "port" "attribute" "function" "activity"
                    "task" "codel" "validate" "exception" "event" "remote" "local" "provides" "uses"
                    "extends" "require" "codels-require" "version" "lang" "email" "doc" "in" "out"
                    "inout" "multiple" "period" "delay" "priority" "scheduling" "stack" "async"
                    "throw" "throws" "interrupts" "interrupt" "before" "after" "yield" "wcet" "pause"
                    "scenario" "system" "check" "policy" "semantics" "await" "request" "on")
                  'symbols)
     . font-lock-keyword-face)
    ("^[ \t]*#[ \t]*[a-z]+" . font-lock-preprocessor-face)
    ("\\_<\\(?:[0-9][0-9.]*\\|0x[0-9a-fA-F]+\\|TRUE\\|FALSE\\|true\\|false\\)\\_>" . font-lock-constant-face)
    ("<\\([a-zA-Z_0-9, ]+\\)>" 1 font-lock-variable-name-face))
  "Colours of keywords, types, directives, constants and events.")

(define-derived-mode genom3-mode prog-mode "GenoM3"
  "Mode for GenoM3 component specifications and their verification scenarios."
  (setq-local comment-start "// "
              comment-end ""
              font-lock-defaults '(genom3-font-lock)
              indent-tabs-mode nil))
(modify-syntax-entry ?/ ". 124b" genom3-mode-syntax-table)
(modify-syntax-entry ?* ". 23" genom3-mode-syntax-table)
(modify-syntax-entry ?\n "> b" genom3-mode-syntax-table)
(modify-syntax-entry ?_ "_" genom3-mode-syntax-table)
(add-to-list 'auto-mode-alist '("\\.\\(gen\\|scn\\)\\'" . genom3-mode))

(defcustom dotgen-trust nil
  "Answers to the question of trust: an alist of folders and t or nil."
  :type '(alist :key-type directory :value-type boolean)
  :group 'eglot)

(defun dotgen-trusted (folder)
  "Return non-nil if the server may run programs for FOLDER; ask once."
  (let ((answer (assoc folder dotgen-trust)))
    (unless (or answer noninteractive)
      (setq answer (cons folder (y-or-n-p (format "Let dotgen run pkg-config and templates of %s? " folder))))
      (customize-save-variable 'dotgen-trust (cons answer dotgen-trust)))
    (cdr answer)))

(defun dotgen-server (&rest _)
  "Return the command of the server, with the options for the project."
  (let* ((project (project-current))
         (folder (if project (project-root project) default-directory))
         (trusted (if (dotgen-trusted (expand-file-name folder)) t :json-false)))
    (list "dotgen" "lsp" :initializationOptions (list :trusted trusted))))

(add-to-list 'eglot-server-programs '(genom3-mode . dotgen-server))
(add-hook 'genom3-mode-hook #'eglot-ensure)

(defun dotgen-command (name argument)
  "Let the server execute the command NAME with ARGUMENT, and return the result."
  (jsonrpc-request (eglot-current-server) :workspace/executeCommand
                   (list :command name :arguments (vector argument))
                   :timeout 60))

(defun dotgen-uri ()
  "Return the address of the file of this buffer."
  (concat "file://" (url-hexify-string (file-truename buffer-file-name) url-path-allowed-chars)))

(defun dotgen-position ()
  "Return point as the protocol counts: lines from 0, and units of UTF-16."
  (let ((before (buffer-substring-no-properties (line-beginning-position) (point))))
    (list :line (1- (line-number-at-pos nil t))
          :character (/ (length (encode-coding-string before 'utf-16le)) 2))))

(defun dotgen-generate ()
  "Run a template over this specification; the server asks for the template."
  (interactive)
  (dotgen-command "dotgen.generate" (list :uri (dotgen-uri))))

(defun dotgen-diagram (kind)
  "Draw the machine at point as Mermaid; with a prefix argument, the whole system.
KIND is `fsm', `system' or `locks'."
  (interactive (list (if current-prefix-arg "system" "fsm")))
  (let ((text (dotgen-command "dotgen.diagram.mermaid"
                              (list :kind kind
                                    :textDocument (list :uri (dotgen-uri))
                                    :position (dotgen-position)))))
    (unless text (user-error "There is nothing to draw here"))
    (with-current-buffer (get-buffer-create "*dotgen diagram*")
      (erase-buffer)
      (insert text)
      (display-buffer (current-buffer)))))

(provide 'genom3-mode)
;;; genom3-mode.el ends here
