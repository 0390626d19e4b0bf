#include "acreader.h"
#include "reader_c_types.h"

genom_event
re_start(int32_t *runs, const genom_context self)
{
  (void)self;
  *runs = 0;
  return reader_pause_read;
}

genom_event
re_read(const reader_trail *trail, const reader_each *each, const reader_seen *seen,
            const reader_sum *sum, const genom_context self)
{
  m_track *from, *to;
  uint32_t i;

  if (trail->read(self) != genom_ok || trail->data(self) == NULL) return reader_pause_read;
  from = trail->data(self);
  to = seen->data(self);
  if (to->_maximum < from->_length && genom_sequence_reserve(to, from->_length)) return NULL;
  to->_length = from->_length;
  for (i = 0; i < from->_length; i++) to->_buffer[i] = from->_buffer[from->_length - 1 - i];
  seen->write(self);
  if (each->read("a", self) == genom_ok && each->data("a", self) != NULL)
    *sum->data(self) = *each->data("a", self) + 1;
  sum->write(self);
  return reader_pause_read;
}
