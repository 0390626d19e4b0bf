/* What every codel may return. Written by dotgen from the description of the C mapping. */
#ifndef H_GENOM3_C_EXCEPTION
#define H_GENOM3_C_EXCEPTION

#include <stdint.h>

#include "genom3/c/context.h"
#include "genom3/c/event.h"

genom_event genom_weak genom_ok = NULL;

const char genom_extern_weak genom_fatal[] = "::genom::fatal";
const char genom_extern_weak genom_unkex_id[] = "::genom::unkex";
const char genom_extern_weak genom_syserr_id[] = "::genom::syserr";

typedef struct genom_unkex_detail {
  char what[128];
} genom_unkex_detail;

typedef struct genom_syserr_detail {
  int32_t code;
} genom_syserr_detail;

static inline genom_event
genom_unkex(genom_unkex_detail *detail, genom_context self)
{
  return self->raise(genom_unkex_id, detail, sizeof(*detail), self);
}

static inline genom_event
genom_syserr(genom_syserr_detail *detail, genom_context self)
{
  return self->raise(genom_syserr_id, detail, sizeof(*detail), self);
}

#endif
