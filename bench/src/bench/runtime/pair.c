#include "acpair.h"
#include "pair_c_types.h"

genom_event
pair_first(const genom_context self)
{
  (void)self;
  return pair_pause_start;
}

genom_event
pair_second(const genom_context self)
{
  (void)self;
  return pair_pause_start;
}
