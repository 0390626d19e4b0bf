
/* Strings that were made here. Codels may put others in their place, which are none of ours. */
struct glue_string {
  struct glue_string *next;
  char text[];
};
static struct glue_string *glue_strings[1024];

static inline struct glue_string **
glue_string_place(const char *text)
{
  return &glue_strings[((uintptr_t)text >> 4) % 1024];
}

static inline void
glue_string_free(char *text)
{
  struct glue_string **at;

  for (at = glue_string_place(text); *at != NULL; at = &(*at)->next) {
    if ((*at)->text == text) {
      struct glue_string *it = *at;
      *at = it->next;
      free(it);
      return;
    }
  }
}

static inline char *
glue_string_make(struct glue_reader *r)
{
  uint32_t length = glue_get_length(r);
  struct glue_string *it = (struct glue_string *)calloc(1, sizeof(*it) + length + 1);
  struct glue_string **at;

  if (it == NULL) abort();
  glue_get(r, it->text, length);
  at = glue_string_place(it->text);
  it->next = *at;
  *at = it;
  return it->text;
}

/* The exception that this thread has raised last. */
static __thread genom_event glue_raised_id;
static __thread void *glue_raised_detail;

static genom_event
glue_raise(genom_event exception, void *detail, size_t size, genom_context self)
{
  (void)self;
  free(glue_raised_detail);
  glue_raised_detail = NULL;
  if (detail != NULL && size > 0) {
    glue_raised_detail = malloc(size);
    if (glue_raised_detail == NULL) abort();
    memcpy(glue_raised_detail, detail, size);
  }
  glue_raised_id = exception;
  return exception;
}

static const void *
glue_raised(genom_event *exception, genom_context self)
{
  (void)self;
  if (exception != NULL) *exception = glue_raised_id;
  return glue_raised_detail;
}

static const struct genom_context_iface glue_context = { glue_raise, glue_raised, NULL };
