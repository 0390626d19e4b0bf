
/* Memory that was made here: strings, and buffers of sequences. Codels may put other memory in its place, which
 * is none of ours. What was made for a request has the instance of the request as owner. */
struct glue_block {
  struct glue_block *next;
  void *data;
  uint32_t owner;
};
#define GLUE_NOBODY UINT32_MAX
#define GLUE_PLACES 1024
static struct glue_block *glue_blocks[GLUE_PLACES];
static pthread_mutex_t glue_blocks_mutex = PTHREAD_MUTEX_INITIALIZER;
/* The number of blocks that have an owner. */
static size_t glue_owned_blocks;
/* The owner of what is made now. Guarded by glue_mutex. */
static uint32_t glue_owner = GLUE_NOBODY;

/* The place of a block in its list, or the end of the list. */
static inline struct glue_block **
glue_find(const void *data)
{
  struct glue_block **at = &glue_blocks[((uintptr_t)data >> 4) % GLUE_PLACES];

  while (*at != NULL && (*at)->data != data) at = &(*at)->next;
  return at;
}

static inline void
glue_remove(struct glue_block **at)
{
  struct glue_block *it = *at;

  if (it->owner != GLUE_NOBODY) glue_owned_blocks--;
  *at = it->next;
  free(it->data);
  free(it);
}

static inline void
glue_add(void *data)
{
  struct glue_block *it = (struct glue_block *)malloc(sizeof(*it));
  struct glue_block **at;

  if (it == NULL) abort();
  it->data = data;
  it->owner = glue_owner;
  pthread_mutex_lock(&glue_blocks_mutex);
  if (it->owner != GLUE_NOBODY) glue_owned_blocks++;
  at = glue_find(data);
  it->next = *at;
  *at = it;
  pthread_mutex_unlock(&glue_blocks_mutex);
}

/* Gives memory back, if it was made here. */
static inline void
glue_free(void *data)
{
  struct glue_block **at;

  pthread_mutex_lock(&glue_blocks_mutex);
  at = glue_find(data);
  if (*at != NULL) glue_remove(at);
  pthread_mutex_unlock(&glue_blocks_mutex);
}

static inline int
glue_owned(void)
{
  int some;

  pthread_mutex_lock(&glue_blocks_mutex);
  some = glue_owned_blocks > 0;
  pthread_mutex_unlock(&glue_blocks_mutex);
  return some;
}

/* Memory that a request gave away: it stays when the request ends. */
static inline void
glue_keep(void *data)
{
  struct glue_block **at;

  if (data == NULL) return;
  pthread_mutex_lock(&glue_blocks_mutex);
  at = glue_find(data);
  if (*at != NULL && (*at)->owner != GLUE_NOBODY) {
    (*at)->owner = GLUE_NOBODY;
    glue_owned_blocks--;
  }
  pthread_mutex_unlock(&glue_blocks_mutex);
}

/* Gives back what was made for a request. */
static inline void
glue_forget(uint32_t owner)
{
  struct glue_block **at;
  int place;

  pthread_mutex_lock(&glue_blocks_mutex);
  for (place = 0; glue_owned_blocks > 0 && place < GLUE_PLACES; place++)
    for (at = &glue_blocks[place]; *at != NULL;)
      if ((*at)->owner == owner) glue_remove(at);
      else at = &(*at)->next;
  pthread_mutex_unlock(&glue_blocks_mutex);
}

static inline char *
glue_string_make(struct glue_reader *r)
{
  uint32_t length = glue_get_length(r);
  char *text = (char *)calloc(1, (size_t)length + 1);

  if (text == NULL) abort();
  glue_get(r, text, length);
  glue_add(text);
  return text;
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
