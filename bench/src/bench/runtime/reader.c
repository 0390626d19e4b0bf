#include "acreader.h"
#include "reader_c_types.h"
#include "stamp.h"

/* Notes the age of each new value. */
genom_event
read_value(const reader_sent *sent, const genom_context self)
{
  static uint64_t last;
  const m_value *value;

  if (sent->read(self) != genom_ok) return reader_pause_start;
  value = sent->data(self);
  if (value == NULL || value->at == 0 || value->at == last) return reader_pause_start;
  last = value->at;
  note(now() - last);
  return reader_pause_start;
}
