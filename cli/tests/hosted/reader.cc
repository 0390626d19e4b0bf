#include "acreader.h"
#include "reader_cxx_types.h"

genom::event
re_start(int32_t &runs)
{
  runs = 0;
  return reader::pause::read;
}

genom::event
re_read(reader::trail &trail, reader::each &each, reader::seen &seen, reader::sum &sum)
{
  trail.read();
  const m::track &from = trail.data();
  seen.data().assign(from.rbegin(), from.rend());
  seen.write();
  each.read("a");
  sum.data() = each.data("a") + 1;
  sum.write();
  return reader::pause::read;
}
