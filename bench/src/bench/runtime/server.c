#include "acserver.h"
#include "server_c_types.h"

genom_event
do_twice(int32_t given, int32_t *result, const genom_context self)
{
  (void)self;
  *result = 2 * given;
  return genom_ok;
}
