/*
 * Time stamps, for the codels of this folder. It needs the mapped type of a
 * component, so that it is included after the types.
 */
#ifndef QUAD_STAMPS_H
#define QUAD_STAMPS_H

/** Returns a time stamp in seconds. */
static inline double
seconds(or_time_ts ts)
{
  return ts.sec + ts.nsec * 1e-9;
}

#endif /* QUAD_STAMPS_H */
