// The external scanner of the genom3 grammar: directives end with their line, which the whitespace rules of
// tree-sitter cannot express. The scanner has no state.
#include "tree_sitter/parser.h"

#include <string.h>

enum { PREPROC_TEXT, ZERO, PARAMETERS_BEGIN, LINE_END, INACTIVE, MACRO_ARGUMENTS, ERROR_SENTINEL };

static void advance(TSLexer *lexer) { lexer->advance(lexer, false); }
static void skip(TSLexer *lexer) { lexer->advance(lexer, true); }

static bool is_blank(int32_t c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
static bool at_line_end(TSLexer *lexer) {
  return lexer->lookahead == '\n' || lexer->lookahead == '\r' || lexer->eof(lexer);
}

// Passes a line end, `\n` or `\r\n`.
static void pass_line_end(TSLexer *lexer) {
  if (lexer->lookahead == '\r') advance(lexer);
  if (lexer->lookahead == '\n') advance(lexer);
}

// Passes the rest of a string or character after its opening quote. Without `lines` the literal ends with its line.
static void pass_literal(TSLexer *lexer, int32_t quote, bool lines) {
  while (!lexer->eof(lexer) && (lines || !at_line_end(lexer))) {
    int32_t c = lexer->lookahead;
    advance(lexer);
    if (c == quote) return;
    if (c == '\\' && !lexer->eof(lexer)) {
      if (at_line_end(lexer)) pass_line_end(lexer);
      else advance(lexer);
    }
  }
}

// Passes a block comment after `/*`.
static void pass_block_comment(TSLexer *lexer) {
  int32_t before = 0;
  while (!lexer->eof(lexer)) {
    int32_t c = lexer->lookahead;
    advance(lexer);
    if (before == '*' && c == '/') return;
    before = c;
  }
}

// Passes the rest of a line, without its end. A backslash joins the line with the next one.
static void pass_line(TSLexer *lexer) {
  while (!at_line_end(lexer)) {
    int32_t c = lexer->lookahead;
    advance(lexer);
    if (c == '\\' && at_line_end(lexer)) pass_line_end(lexer);
  }
}

// Passes the rest of a line of text in which comments may begin.
static void pass_text_line(TSLexer *lexer) {
  while (!at_line_end(lexer)) {
    int32_t c = lexer->lookahead;
    advance(lexer);
    if (c == '\\' && at_line_end(lexer)) {
      pass_line_end(lexer);
    } else if (c == '/' && lexer->lookahead == '*') {
      advance(lexer);
      pass_block_comment(lexer);
    } else if (c == '/' && lexer->lookahead == '/') {
      pass_line(lexer);
    }
  }
}

// The rest of the line of a directive: text up to a comment or the end of the line, or that end.
static bool scan_line(TSLexer *lexer, const bool *valid) {
  if (valid[PARAMETERS_BEGIN] && lexer->lookahead == '(') {
    advance(lexer);
    lexer->mark_end(lexer);
    lexer->result_symbol = PARAMETERS_BEGIN;
    return true;
  }
  for (;;) {
    if (is_blank(lexer->lookahead)) {
      skip(lexer);
    } else if (lexer->lookahead == '\\') {
      // A splice, or text that begins with a backslash: the token leaves the backslash out.
      skip(lexer);
      if (!at_line_end(lexer)) break;
      if (lexer->lookahead == '\r') skip(lexer);
      if (lexer->lookahead == '\n') skip(lexer);
    } else {
      break;
    }
  }
  if (at_line_end(lexer)) {
    if (!valid[LINE_END]) return false;
    pass_line_end(lexer);
    lexer->mark_end(lexer);
    lexer->result_symbol = LINE_END;
    return true;
  }
  if (!valid[PREPROC_TEXT]) return false;
  // The name of a macro or pragma, and the parameters of a macro, are tokens of the grammar.
  bool any = false, only_zero = true;
  int zeros = 0;
  while (!at_line_end(lexer)) {
    int32_t c = lexer->lookahead;
    if (c == '/') {
      lexer->mark_end(lexer);
      advance(lexer);
      if (lexer->lookahead == '/' || lexer->lookahead == '*') {
        if (!any) return false;
        goto done;
      }
      any = true;
      only_zero = false;
      continue;
    }
    advance(lexer);
    if (c == '\\' && at_line_end(lexer)) {
      pass_line_end(lexer);
      continue;
    }
    if (c == '"' || c == '\'') pass_literal(lexer, c, false);
    if (c == '0') zeros++;
    else if (!is_blank(c)) only_zero = false;
    if (!is_blank(c)) {
      any = true;
      lexer->mark_end(lexer);
    }
  }
  if (!any) return false;
done:
  lexer->result_symbol = valid[ZERO] && only_zero && zeros == 1 ? ZERO : PREPROC_TEXT;
  return true;
}

// The text under `#if 0`, perhaps empty, up to the line of its `#else`, `#elif` or `#endif`.
static bool scan_inactive(TSLexer *lexer) {
  lexer->mark_end(lexer);
  int depth = 0;
  while (!lexer->eof(lexer)) {
    lexer->mark_end(lexer);
    while (is_blank(lexer->lookahead)) advance(lexer);
    bool hash = false;
    if (lexer->lookahead == '#') {
      hash = true;
      advance(lexer);
    } else if (lexer->lookahead == '%') {
      advance(lexer);
      if (lexer->lookahead == ':') {
        hash = true;
        advance(lexer);
      }
    }
    if (hash) {
      while (is_blank(lexer->lookahead)) advance(lexer);
      char word[8] = "";
      unsigned length = 0;
      while (lexer->lookahead >= 'a' && lexer->lookahead <= 'z') {
        if (length < sizeof word - 1) word[length] = (char)lexer->lookahead;
        length++;
        advance(lexer);
      }
      if (length < sizeof word) {
        word[length] = 0;
        if (!strcmp(word, "if") || !strcmp(word, "ifdef") || !strcmp(word, "ifndef")) depth++;
        else if (!strcmp(word, "endif") && depth-- == 0) break;
        else if (depth == 0 && (!strcmp(word, "else") || !strcmp(word, "elif"))) break;
      }
    }
    pass_text_line(lexer);
    pass_line_end(lexer);
    if (lexer->eof(lexer)) lexer->mark_end(lexer);
  }
  lexer->result_symbol = INACTIVE;
  return true;
}

static bool scan_macro_arguments(TSLexer *lexer) {
  while (is_blank(lexer->lookahead) || lexer->lookahead == '\n' || lexer->lookahead == '\r') skip(lexer);
  if (lexer->lookahead != '(') return false;
  int depth = 0;
  while (!lexer->eof(lexer)) {
    int32_t c = lexer->lookahead;
    advance(lexer);
    if (c == '(') {
      depth++;
    } else if (c == ')') {
      if (--depth == 0) {
        lexer->mark_end(lexer);
        lexer->result_symbol = MACRO_ARGUMENTS;
        return true;
      }
    } else if (c == '"') {
      pass_literal(lexer, c, true);
    } else if (c == '\'') {
      pass_literal(lexer, c, false);
    } else if (c == '/' && lexer->lookahead == '*') {
      advance(lexer);
      pass_block_comment(lexer);
    } else if (c == '/' && lexer->lookahead == '/') {
      pass_line(lexer);
    }
  }
  return false;
}

void *tree_sitter_genom3_external_scanner_create(void) { return NULL; }
void tree_sitter_genom3_external_scanner_destroy(void *payload) { (void)payload; }
unsigned tree_sitter_genom3_external_scanner_serialize(void *payload, char *buffer) {
  (void)payload, (void)buffer;
  return 0;
}
void tree_sitter_genom3_external_scanner_deserialize(void *payload, const char *buffer, unsigned length) {
  (void)payload, (void)buffer, (void)length;
}

bool tree_sitter_genom3_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid) {
  (void)payload;
  if (valid[ERROR_SENTINEL]) return false;
  if (valid[PREPROC_TEXT] || valid[LINE_END]) return scan_line(lexer, valid);
  if (valid[INACTIVE]) return scan_inactive(lexer);
  if (valid[MACRO_ARGUMENTS]) return scan_macro_arguments(lexer);
  return false;
}
