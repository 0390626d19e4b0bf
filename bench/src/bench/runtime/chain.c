#include "acchain.h"
#include "chain_c_types.h"
#include "stamp.h"

genom_event
chain_at_first(const genom_context self)
{
  (void)self;
  note(now());
  return chain_second;
}

genom_event
chain_at_second(const genom_context self)
{
  (void)self;
  note(now());
  return chain_third;
}

genom_event
chain_at_third(const genom_context self)
{
  (void)self;
  note(now());
  return chain_fourth;
}

genom_event
chain_at_fourth(const genom_context self)
{
  (void)self;
  note(now());
  return chain_pause_start;
}
