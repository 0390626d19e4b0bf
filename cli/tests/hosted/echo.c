#include "acecho.h"
#include "echo_c_types.h"

genom_event
do_start(int32_t *gain, const echo_each *each, const genom_context self)
{
  *gain = 7;
  if (each->data("a", self) != NULL) return NULL;
  if (each->open("a", self) != genom_ok) return NULL;
  return echo_pause_loop;
}

genom_event
do_loop(int32_t gain, const echo_trail *trail, const echo_each *each, const genom_context self)
{
  m_track *it = trail->data(self);
  uint32_t n = it->_length + 1;

  if (n > 3) n = 3;
  if (it->_maximum < n && genom_sequence_reserve(it, n)) return NULL;
  it->_length = n;
  it->_buffer[n - 1].x = n;
  it->_buffer[n - 1].y = gain;
  trail->write(self);
  *each->data("a", self) = gain * 10;
  each->write("a", self);
  return echo_pause_loop;
}

genom_event
do_mirror(const m_all *given, m_all *back, const genom_context self)
{
  (void)self;
  *back = *given;
  return genom_ok;
}

genom_event
do_fail(int16_t code, const genom_context self)
{
  echo_e_bad_detail d = { code };
  return code ? echo_e_bad(&d, self) : echo_e_plain(self);
}

genom_event
do_gain(int32_t gain, const genom_context self)
{
  return gain < 0 ? echo_e_plain(self) : genom_ok;
}

genom_event
do_count(int32_t n, int32_t *seen, const genom_context self)
{
  (void)self;
  if (n < 0) return "nonsense";
  return ++*seen < n ? echo_pause_start : echo_ether;
}

genom_event
do_stop(int32_t *seen, const genom_context self)
{
  (void)self;
  *seen = -1;
  return echo_ether;
}
