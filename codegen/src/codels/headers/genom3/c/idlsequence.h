/* Sequences. Written by dotgen from the description of the C mapping. */
#ifndef H_GENOM3_C_IDLSEQUENCE
#define H_GENOM3_C_IDLSEQUENCE

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Gives a buffer of `maximum` elements the first `length` of the old one; returns 0, or -1 when
 * there is no memory. */
static inline int
genom_sequence_grow(uint32_t maximum, size_t size, uint32_t *length, uint32_t *old_maximum,
                    void **buffer, void (**release)(void *))
{
  void *fresh = NULL;

  if (maximum > 0) {
    fresh = calloc(maximum, size);
    if (fresh == NULL) return -1;
  }
  if (*length > maximum) *length = maximum;
  if (*length > 0 && *buffer != NULL) memcpy(fresh, *buffer, *length * size);
  if (*release != NULL && *buffer != NULL) (*release)(*buffer);
  *buffer = fresh;
  *old_maximum = maximum;
  *release = fresh != NULL ? free : NULL;
  return 0;
}

/* Room for at least `length` elements in an unbounded sequence. */
#define genom_sequence_reserve(sequence, length)                                                  \
  genom_sequence_grow((length), sizeof(*(sequence)->_buffer), &(sequence)->_length,               \
                      &(sequence)->_maximum, (void **)&(sequence)->_buffer,                       \
                      &(sequence)->_release)

#endif
