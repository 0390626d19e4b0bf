#include "acwriter.h"
#include "writer_c_types.h"
#include "stamp.h"

genom_event
write_value(const writer_sent *sent, const genom_context self)
{
  sent->data(self)->at = now();
  sent->write(self);
  return writer_pause_start;
}
