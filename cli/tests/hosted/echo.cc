#include "acecho.h"
#include "echo_cxx_types.h"

genom::event
do_start(int32_t &gain, echo::each &each)
{
  gain = 7;
  try {
    each.data("a");
    return nullptr;
  } catch (genom::syserr &) {
  }
  each.open("a");
  return echo::pause::loop;
}

genom::event
do_loop(int32_t gain, echo::trail &trail, echo::each &each)
{
  m::track &it = trail.data();
  if (it.size() < 3) it.push_back(m::point());
  it.back().x = it.size();
  it.back().y = gain;
  trail.write();
  each.data("a") = gain * 10;
  each.write("a");
  return echo::pause::loop;
}

genom::event
do_mirror(const m::all &given, m::all &back)
{
  back = given;
  return genom::ok;
}

genom::event
do_fail(int16_t code)
{
  if (!code) throw echo::e_plain();
  echo::e_bad bad;
  bad.detail.code = code;
  throw bad;
}

genom::event
do_gain(int32_t gain)
{
  if (gain < 0) throw echo::e_plain();
  return genom::ok;
}

genom::event
do_count(int32_t n, int32_t &seen)
{
  return ++seen < n ? echo::pause::start : echo::ether;
}

genom::event
do_stop(int32_t &seen)
{
  seen = -1;
  return echo::ether;
}
