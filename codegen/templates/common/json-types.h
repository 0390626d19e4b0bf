<'
# Reading and writing data as JSON, in C. Templates for clients expand this for the types they need:
# the argument is a list of types, each after those it is made of. For each type T it defines
#
#   int json_scan_T(T *data, const char **json)                           reads, and moves on
#   int json_print_T(char **text, char **end, size_t *size, const T data) appends to a growing text
#
# Both return 0, or a number of <errno.h>. A text to append to begins as three zeros.
lassign $argv types
if {[llength $argv] != 1} { error "json-types.h takes one argument: a list of types" }
lang c
'>
#ifndef __STDC_FORMAT_MACROS
# define __STDC_FORMAT_MACROS
#endif
#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef __GNUC__
# define JSON_UNUSED __attribute__((unused))
#else
# define JSON_UNUSED
#endif

/* A size that templates begin a text with. */
#define JSON_MINBUF 128

#define json_skip_whitespace(json) ((json) += strspn((json), " \t\r\n"))

/* Appends LENGTH characters; the text always ends with a zero. */
static JSON_UNUSED int
json_append(char **text, char **end, size_t *size, const char *more, size_t length)
{
  size_t used = *text ? (size_t)(*end - *text) : 0;

  if (used + length + 1 > *size) {
    size_t wanted = 2 * (used + length) + 128;
    char *moved = (char *)realloc(*text, wanted);
    if (!moved) return ENOMEM;
    *text = moved;
    *size = wanted;
  }
  *end = *text + used;
  memcpy(*end, more, length);
  *end += length;
  **end = '\0';
  return 0;
}

static JSON_UNUSED int
json_append_text(char **text, char **end, size_t *size, const char *more)
{
  return json_append(text, end, size, more, strlen(more));
}

/* A string in quotes. */
static JSON_UNUSED int
json_append_quoted(char **text, char **end, size_t *size, const char *string)
{
  int s = json_append(text, end, size, "\"", 1);
  for (; !s && *string; string++) {
    unsigned char c = (unsigned char)*string;
    char escaped[8];
    if (c == '"' || c == '\\')
      snprintf(escaped, sizeof(escaped), "\\%c", c);
    else if (c < 0x20)
      snprintf(escaped, sizeof(escaped), "\\u%04x", c);
    else
      snprintf(escaped, sizeof(escaped), "%c", c);
    s = json_append_text(text, end, size, escaped);
  }
  return s ? s : json_append(text, end, size, "\"", 1);
}

/* Passes one character, with the blanks around it. */
static JSON_UNUSED int
json_expect(const char **json, char wanted)
{
  json_skip_whitespace(*json);
  if (**json != wanted) return EINVAL;
  (*json)++;
  json_skip_whitespace(*json);
  return 0;
}

/* After an element: 1 when another follows, 0 after the closing character, -1 for anything else. */
static JSON_UNUSED int
json_more(const char **json, char close)
{
  json_skip_whitespace(*json);
  if (**json == ',') {
    (*json)++;
    json_skip_whitespace(*json);
    return 1;
  }
  if (**json != close) return -1;
  (*json)++;
  return 0;
}

/* Passes an opening character: 1 when elements follow, 0 when it is closed at once, -1 if it is not there. */
static JSON_UNUSED int
json_open(const char **json, char open, char close)
{
  if (json_expect(json, open)) return -1;
  if (**json != close) return 1;
  (*json)++;
  return 0;
}

/* Reads a string in quotes into at most SIZE characters, the zero included; without BUFFER it only
 * passes it. LENGTH is what it needs, without the zero. */
static JSON_UNUSED int
json_scan_quoted(char *buffer, size_t size, size_t *length, const char **json)
{
  size_t n = 0;

  json_skip_whitespace(*json);
  if (**json != '"') return EINVAL;
  for ((*json)++; **json != '"'; (*json)++) {
    char bytes[4];
    size_t count = 1, i;
    bytes[0] = **json;
    if (!**json) return EINVAL;
    if (**json == '\\') {
      (*json)++;
      switch (**json) {
        case 'n': bytes[0] = '\n'; break;
        case 't': bytes[0] = '\t'; break;
        case 'r': bytes[0] = '\r'; break;
        case 'b': bytes[0] = '\b'; break;
        case 'f': bytes[0] = '\f'; break;
        case 'u': {
          unsigned int code = 0;
          for (i = 1; i <= 4; i++) {
            char digit[2] = { (*json)[i], '\0' };
            if (!isxdigit((unsigned char)digit[0])) return EINVAL;
            code = 16 * code + (unsigned int)strtoul(digit, NULL, 16);
          }
          *json += 4;
          if (code < 0x80) {
            bytes[0] = (char)code;
          } else if (code < 0x800) {
            bytes[0] = (char)(0xc0 | code >> 6);
            bytes[1] = (char)(0x80 | (code & 0x3f));
            count = 2;
          } else {
            bytes[0] = (char)(0xe0 | code >> 12);
            bytes[1] = (char)(0x80 | (code >> 6 & 0x3f));
            bytes[2] = (char)(0x80 | (code & 0x3f));
            count = 3;
          }
          break;
        }
        case '\0': return EINVAL;
        default: bytes[0] = **json;
      }
    }
    for (i = 0; i < count; i++, n++)
      if (buffer && n < size) buffer[n] = bytes[i];
  }
  (*json)++;
  if (buffer) {
    if (n >= size) return EINVAL;
    buffer[n] = '\0';
  }
  *length = n;
  return 0;
}

/* Reads a member's name and the colon. */
static JSON_UNUSED int
json_scan_key(char *buffer, size_t size, const char **json)
{
  size_t length;
  int s = json_scan_quoted(buffer, size, &length, json);
  return s ? s : json_expect(json, ':');
}

<'
# Text that reads the members of DATA from an object.
proc json_members {members prefix} {
  puts "  more = json_open(json, '\{', '\}');"
  puts "  while (more > 0) \{"
  puts "    if ((s = json_scan_key(key, sizeof(key), json))) return s;"
  foreach m $members {
    puts "    if (!strcmp(key, \"[$m name]\")) \{"
    puts "      if ((s = json_scan_[[$m type] mangle]([$m pass reference $prefix[$m name]], json))) return s;"
    puts "    \} else"
  }
  puts "      return EINVAL;"
  puts "    more = json_more(json, '\}');"
  puts "  \}"
  puts "  if (more < 0) return EINVAL;"
}

# Text that reads the elements of an array or sequence, given in order or by index. BEFORE makes room
# for element i, AFTER counts it.
proc json_elements {element at before after} {
  puts "  json_skip_whitespace(*json);"
  puts "  close = **json == '\{' ? '\}' : '\]';"
  puts "  more = json_open(json, **json == '\{' ? '\{' : '\[', close);"
  puts "  for (i = 0; more > 0; i++) \{"
  puts "    if (close == '\}') \{"
  puts "      char *rest;"
  puts "      if (json_scan_key(key, sizeof(key), json)) return EINVAL;"
  puts "      i = strtoul(key, &rest, 0);"
  puts "      if (rest == key || *rest) return EINVAL;"
  puts "    \}"
  puts "    $before"
  puts "    if ((s = json_scan_[$element mangle]([$element pass reference $at], json))) return s;"
  puts "    $after"
  puts "    more = json_more(json, close);"
  puts "  \}"
  puts "  if (more < 0) return EINVAL;"
}
'>
<'foreach t $types {'>
static inline JSON_UNUSED int
json_scan_<"[$t mangle]">(<"[$t argument reference data]">, const char **json);
static inline JSON_UNUSED int
json_print_<"[$t mangle]">(char **text, char **end, size_t *size, <"[$t argument value data]">);
<'}'>
<'foreach t $types {'>

/* <"[$t mangle]"> */
static inline JSON_UNUSED int
json_scan_<"[$t mangle]">(<"[$t argument reference data]">, const char **json)
{
  int s = 0;
<'
  switch -glob -- [$t kind] {
    typedef - const - forward* - {* member} {
      puts "  s = json_scan_[[$t type] mangle](data, json);"
    }
    struct - exception {
      if {[llength [$t members]]} {
        puts "  int more;\n  char key\[128\];"
        json_members [$t members] data->
      } else {
        puts "  (void)data;"
        puts "  if (json_open(json, '\{', '\}')) return EINVAL;"
      }
    }
    union {
      puts "  int more, outer;\n  char key\[128\];"
      puts "  outer = json_open(json, '\{', '\}');"
      puts "  while (outer > 0) \{"
      puts "  if ((s = json_scan_key(key, sizeof(key), json))) return s;"
      puts "  if (!strcmp(key, \"d\")) \{"
      puts "    if ((s = json_scan_[[$t discriminator] mangle]([[$t discriminator] pass reference data->_d], json))) return s;"
      puts "  \} else if (!strcmp(key, \"u\")) \{"
      json_members [$t members] data->_u.
      puts "  \} else return EINVAL;"
      puts "  outer = json_more(json, '\}');"
      puts "  \}"
      puts "  if (outer < 0) return EINVAL;"
    }
    array {
      puts "  unsigned long i;\n  int more;\n  char close, key\[32\];"
      json_elements [$t type] "data\[i\]" "if (i >= [$t length]) return EINVAL;" ""
    }
    sequence {
      puts "  unsigned long i;\n  int more;\n  char close, key\[32\];"
      if {[catch {$t length} bound]} {
        set room "if (i >= data->_length && (s = genom_sequence_reserve(data, i + 1))) return s;"
      } else {
        set room "if (i >= $bound) return EINVAL;"
      }
      json_elements [$t type] "data->_buffer\[i\]" $room \
          "if (close == '\]' || i >= data->_length) data->_length = i + 1;"
    }
    optional {
      puts "  json_skip_whitespace(*json);"
      puts "  data->_present = 0;"
      puts "  if (!strncmp(*json, \"null\", 4)) \{ *json += 4; return 0; \}"
      puts "  s = json_scan_[[$t type] mangle]([[$t type] pass reference data->_value], json);"
      puts "  data->_present = !s;"
    }
    string {
      puts "  size_t length;"
      if {[catch {$t length} bound]} {
        puts "  const char *start = *json;\n  char *copy;"
        puts "  if ((s = json_scan_quoted(NULL, 0, &length, json))) return s;"
        puts "  if (!(copy = (char *)malloc(length + 1))) return ENOMEM;"
        puts "  *json = start;"
        puts "  if ((s = json_scan_quoted(copy, length + 1, &length, json))) \{ free(copy); return s; \}"
        puts "  free(*data);\n  *data = copy;"
      } else {
        puts "  s = json_scan_quoted(data, $bound, &length, json);"
      }
    }
    char {
      puts "  char key\[2\];\n  size_t length;"
      puts "  if ((s = json_scan_quoted(key, sizeof(key), &length, json))) return s;"
      puts "  *data = key\[0\];"
    }
    enum {
      puts "  char key\[256\];\n  size_t length;"
      puts "  if ((s = json_scan_quoted(key, sizeof(key), &length, json))) return s;"
      foreach e [$t members] {
        set whole [$e fullname]
        puts "  if (!strcmp(key, \"$whole\") || !strcmp(key, \"[string trimleft $whole :]\") || !strcmp(key, \"[$e name]\")) *data = [$e cname]; else"
      }
      puts "  if (!strcmp(key, \"<invalid>\")) *data = ([$t declarator])-1; else s = EINVAL;"
    }
    boolean {
      puts "  char *rest;"
      puts "  json_skip_whitespace(*json);"
      puts "  if (!strncmp(*json, \"true\", 4)) \{ *data = 1; *json += 4; return 0; \}"
      puts "  if (!strncmp(*json, \"false\", 5)) \{ *data = 0; *json += 5; return 0; \}"
      puts "  *data = strtol(*json, &rest, 0) != 0;"
      puts "  if (rest == *json) return EINVAL;\n  *json = rest;"
    }
    float - double {
      puts "  char *rest;"
      puts "  json_skip_whitespace(*json);"
      puts "  if (!strncmp(*json, \"null\", 4)) \{ *data = ([$t declarator])nan(\"\"); *json += 4; return 0; \}"
      puts "  *data = ([$t declarator])strtod(*json, &rest);"
      puts "  if (rest == *json) return EINVAL;\n  *json = rest;"
    }
    unsigned* - octet {
      puts "  char *rest;"
      puts "  *data = ([$t declarator])strtoull(*json, &rest, 0);"
      puts "  if (rest == *json) return EINVAL;\n  *json = rest;"
    }
    short - long* {
      puts "  char *rest;"
      puts "  *data = ([$t declarator])strtoll(*json, &rest, 0);"
      puts "  if (rest == *json) return EINVAL;\n  *json = rest;"
    }
    default { puts "  (void)data;\n  (void)json;\n  s = EINVAL;" }
  }
'>
  return s;
}

static inline JSON_UNUSED int
json_print_<"[$t mangle]">(char **text, char **end, size_t *size, <"[$t argument value data]">)
{
  int s = 0;
<'
  switch -glob -- [$t kind] {
    typedef - const - forward* - {* member} {
      puts "  s = json_print_[[$t type] mangle](text, end, size, data);"
    }
    struct - exception {
      set comma "\{"
      if {![llength [$t members]]} {
        puts "  (void)data;\n  if ((s = json_append_text(text, end, size, \"\{\"))) return s;"
      }
      foreach m [$t members] {
        puts "  if ((s = json_append_text(text, end, size, \"$comma\\\"[$m name]\\\":\"))) return s;"
        puts "  if ((s = json_print_[[$m type] mangle](text, end, size, [$m pass value data->[$m name]]))) return s;"
        set comma ","
      }
      puts "  s = json_append_text(text, end, size, \"\}\");"
    }
    union {
      set d [$t discriminator]
      puts "  if ((s = json_append_text(text, end, size, \"\{\\\"d\\\":\"))) return s;"
      puts "  if ((s = json_print_[$d mangle](text, end, size, [$d pass value data->_d]))) return s;"
      puts "  if ((s = json_append_text(text, end, size, \",\\\"u\\\":\{\"))) return s;"
      set default {}
      puts "  switch (data->_d) \{"
      foreach m [$t members] {
        foreach label [$m value] {
          if {$label eq {}} { set default yes; puts "    default:"; continue }
          switch -- [[$d final] kind] {
          enum { set label [language cname $label] }
          char { set label "'$label'" }
        }
          puts "    case $label:"
        }
        puts "      if ((s = json_append_text(text, end, size, \"\\\"[$m name]\\\":\"))) return s;"
        puts "      if ((s = json_print_[[$m type] mangle](text, end, size, [$m pass value data->_u.[$m name]]))) return s;"
        puts "      break;"
      }
      if {$default eq {}} { puts "    default: break;" }
      puts "  \}"
      puts "  s = json_append_text(text, end, size, \"\}\}\");"
    }
    array - sequence {
      set e [$t type]
      if {[$t kind] eq "array"} {
        set length [$t length]; set at "data\[i\]"
      } else {
        set length data->_length; set at "data->_buffer\[i\]"
      }
      puts "  unsigned long i;"
      puts "  if ((s = json_append_text(text, end, size, \"\[\"))) return s;"
      puts "  for (i = 0; i < $length; i++) \{"
      puts "    if (i && (s = json_append_text(text, end, size, \",\"))) return s;"
      puts "    if ((s = json_print_[$e mangle](text, end, size, [$e pass value $at]))) return s;"
      puts "  \}"
      puts "  s = json_append_text(text, end, size, \"\]\");"
    }
    optional {
      puts "  if (!data->_present) return json_append_text(text, end, size, \"null\");"
      puts "  s = json_print_[[$t type] mangle](text, end, size, [[$t type] pass value data->_value]);"
    }
    string { puts "  s = json_append_quoted(text, end, size, data ? data : \"\");" }
    char {
      puts "  char one\[2\] = \{ (char)data, '\\0' \};"
      puts "  s = json_append_quoted(text, end, size, one);"
    }
    enum {
      puts "  switch (data) \{"
      foreach e [$t members] {
        puts "    case [$e cname]: return json_append_text(text, end, size, \"\\\"[$e fullname]\\\"\");"
      }
      puts "  \}"
      puts "  s = json_append_text(text, end, size, \"\\\"<invalid>\\\"\");"
    }
    boolean { puts "  s = json_append_text(text, end, size, data ? \"true\" : \"false\");" }
    float - double {
      set digits [dict get {float 9 double 17} [$t kind]]
      puts "  char number\[32\];"
      puts "  if (isnan(data) || isinf(data)) return json_append_text(text, end, size, \"null\");"
      puts "  snprintf(number, sizeof(number), \"%.${digits}g\", (double)data);"
      puts "  s = json_append_text(text, end, size, number);"
    }
    unsigned* - octet {
      set cast [expr {[$t kind] eq "octet" ? "(uint8_t)" : ""}]
      puts "  char number\[32\];"
      puts "  snprintf(number, sizeof(number), \"%llu\", (unsigned long long)${cast}data);"
      puts "  s = json_append_text(text, end, size, number);"
    }
    short - long* {
      puts "  char number\[32\];"
      puts "  snprintf(number, sizeof(number), \"%lld\", (long long)data);"
      puts "  s = json_append_text(text, end, size, number);"
    }
    default { puts "  (void)data;\n  (void)text;\n  (void)end;\n  (void)size;\n  s = EINVAL;" }
  }
'>
  return s;
}
<'}'>
