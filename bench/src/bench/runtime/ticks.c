#include "acticks.h"
#include "ticks_c_types.h"
#include "stamp.h"

genom_event
ticks_entry(const genom_context self)
{
  (void)self;
  note(now());
  return ticks_pause_start;
}
