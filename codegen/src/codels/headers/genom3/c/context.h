/* The context that codels pass on. Written by dotgen from the description of the C mapping. */
#ifndef H_GENOM3_C_CONTEXT
#define H_GENOM3_C_CONTEXT

#include <stddef.h>

#include "genom3/c/event.h"

struct genom_context_data;
typedef const struct genom_context_iface *genom_context;

struct genom_context_iface {
  /* Raises an exception with `size` bytes of detail; returns what the codel has to return. */
  genom_event (*raise)(genom_event exception, void *detail, size_t size,
                       genom_context self);
  /* Detail of the exception that was raised, whose name goes to `exception`. */
  const void *(*raised)(genom_event *exception, genom_context self);
  struct genom_context_data *data;
};

#endif
