/* What stands between codels and whoever runs them. Written by dotgen.
 *
 * Values cross as bytes: numbers as the machine has them, a string as its length (32 bits) and its
 * bytes, a sequence as its length and its elements, an optional as a byte and its value, a union as its
 * discriminator and the member that it chooses, an enumeration as 32 bits, and structures and arrays as
 * what they hold, in order. */
#include <errno.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define GLUE_EXPORT __attribute__((visibility("default")))
#ifdef __cplusplus
# define GLUE_C extern "C"
#else
# define GLUE_C
#endif

/* Bytes that grow. */
struct glue_buffer {
  unsigned char *bytes;
  size_t size, room;
};

/* Bytes that are read. */
struct glue_reader {
  const unsigned char *bytes;
  size_t left;
  int bad;
};

/* Values are loaded by one thread at a time. */
static pthread_mutex_t glue_mutex = PTHREAD_MUTEX_INITIALIZER;

static inline void
glue_put(struct glue_buffer *b, const void *data, size_t size)
{
  if (b->size + size > b->room) {
    size_t room = (b->size + size) * 2 + 64;
    void *bytes = realloc(b->bytes, room);
    if (bytes == NULL) abort();
    b->bytes = (unsigned char *)bytes;
    b->room = room;
  }
  if (size > 0) memcpy(b->bytes + b->size, data, size);
  b->size += size;
}

static inline void
glue_put_number(struct glue_buffer *b, uint32_t number)
{
  glue_put(b, &number, sizeof(number));
}

static inline void
glue_put_text(struct glue_buffer *b, const char *text, size_t size)
{
  glue_put_number(b, (uint32_t)size);
  glue_put(b, text, size);
}

static inline void
glue_get(struct glue_reader *r, void *data, size_t size)
{
  if (size > r->left) {
    r->bad = 1;
    memset(data, 0, size);
    return;
  }
  memcpy(data, r->bytes, size);
  r->bytes += size;
  r->left -= size;
}

/* A length: never more than there are bytes, as whatever it counts has one at least. */
static inline uint32_t
glue_get_length(struct glue_reader *r)
{
  uint32_t length;

  glue_get(r, &length, sizeof(length));
  if (length > r->left) {
    r->bad = 1;
    return 0;
  }
  return length;
}

/* The newest data of a port, in memory that its writer shares: which turn it is, 0 before the first one, and two places
 * with their sizes, of which that of the turn is whole. Nothing can be written through this mapping. */
struct glue_board {
  uint64_t turn, room, sizes[2];
  unsigned char none[32];
  unsigned char data[];
};

struct glue_shared {
  const struct glue_board *board;
  uint64_t turn;
};

/* Leads to another board; returns the one before, which nobody here looks at any more. */
static inline const struct glue_board *
glue_lead(struct glue_shared *s, const struct glue_board *board)
{
  const struct glue_board *before = s->board;

  s->board = board;
  s->turn = 0;
  return before;
}

/* Copies what is new; whether there is something. */
static inline int
glue_look(struct glue_shared *s, struct glue_buffer *b)
{
  const struct glue_board *from = s->board;
  uint64_t turn, size;

  if (from == NULL) return 0;
  for (;;) {
    turn = __atomic_load_n(&from->turn, __ATOMIC_ACQUIRE);
    if (turn == s->turn) return 0;
    size = __atomic_load_n(&from->sizes[turn % 2], __ATOMIC_RELAXED);
    b->size = 0;
    if (size <= from->room)
      glue_put(b, from->data + (turn % 2) * from->room, (size_t)size);
    /* The writer comes back to this place only after another turn has begun. */
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    if (__atomic_load_n(&from->turn, __ATOMIC_RELAXED) == turn) break;
  }
  s->turn = turn;
  return 1;
}

/* Asks a service of another component, and waits: the number of the remote, its inputs, and what takes the outputs. 0 or an
 * error of the system. */
static int (*glue_asks)(uint32_t remote, const void *inputs, size_t size,
                        void (*put)(void *to, const void *outputs, size_t size), void *to);

static inline void
glue_take_outputs(void *to, const void *outputs, size_t size)
{
  glue_put((struct glue_buffer *)to, outputs, size);
}

static inline int
glue_ask(uint32_t remote, const struct glue_buffer *inputs, struct glue_buffer *outputs)
{
  if (glue_asks == NULL) return ENOSYS;
  return glue_asks(remote, inputs->bytes, inputs->size, glue_take_outputs, outputs);
}

/* What a codel has done to a port: kind 0 write, 1 open, 2 close. Told when the codel has ended. */
static __thread struct glue_buffer glue_written;
static __thread uint32_t glue_writes;

static inline void
glue_tell_port(uint32_t port, const char *id, uint32_t kind)
{
  glue_put_number(&glue_written, port);
  glue_put_text(&glue_written, id, strlen(id));
  glue_put_number(&glue_written, kind);
  glue_writes++;
}

/* Puts the size of what is written between two calls in front of it. */
static inline size_t
glue_begin_block(struct glue_buffer *b)
{
  glue_put_number(b, 0);
  return b->size;
}

static inline void
glue_end_block(struct glue_buffer *b, size_t from)
{
  uint32_t size = (uint32_t)(b->size - from);
  memcpy(b->bytes + from - sizeof(size), &size, sizeof(size));
}

/* How a codel has ended. */
#define GLUE_EVENT 0     /* an event, or nothing at all */
#define GLUE_EXCEPTION 1 /* an exception that the specification declares */
#define GLUE_OTHER 2     /* something that is neither */
