#include "acmikrokopter.h"

#include "mikrokopter_c_types.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "mikrokopter_line.h"


/** Codel mk_comm_start of task comm.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_poll.
 */
genom_event
mk_comm_start(mikrokopter_line_s **line,
              quad_rotors_velocities *measured,
              quad_rotors_inertial *inertia, const genom_context self)
{
  (void)self;
  *line = NULL;
  memset(measured, 0, sizeof *measured);
  memset(inertia, 0, sizeof *inertia);
  return mikrokopter_poll;
}


/** Codel mk_comm_poll of task comm.
 *
 * Triggered by mikrokopter_poll.
 * Yields to mikrokopter_poll, mikrokopter_recv.
 */
genom_event
mk_comm_poll(const mikrokopter_line_s *line, const genom_context self)
{
  (void)self;
  /* As long as a frame of 32 bytes takes, with their start and stop bits; without line, as long as it may. */
  uint32_t baud = line ? line->baud : 500000;
  if (!baud) return mikrokopter_recv;
  long wait = 320L * 1000000000L / baud;
  struct timespec pause = {.tv_nsec = wait < 700000 ? wait : 700000};
  nanosleep(&pause, NULL);
  return mikrokopter_recv;  /* which finds nothing, if no line is open */
}


/** Codel mk_comm_recv of task comm.
 *
 * Triggered by mikrokopter_recv.
 * Yields to mikrokopter_poll.
 */
genom_event
mk_comm_recv(const mikrokopter_line_velocity *line_velocity,
             const mikrokopter_line_inertia *line_inertia,
             mikrokopter_line_s **line,
             quad_rotors_velocities *measured,
             quad_rotors_inertial *inertia, const genom_context self)
{
  if (!*line) return mikrokopter_poll;
  if (line_velocity->read(self) == genom_ok) {
    const quad_rotors_velocities *v = line_velocity->data(self);
    if (v) *measured = *v;
  }
  if (line_inertia->read(self) == genom_ok) {
    const quad_rotors_inertial *i = line_inertia->data(self);
    if (i) *inertia = *i;
  }
  return mikrokopter_poll;
}


/** Codel mk_comm_stop of task comm.
 *
 * Triggered by mikrokopter_stop.
 * Yields to mikrokopter_ether.
 */
genom_event
mk_comm_stop(mikrokopter_line_s **line, const genom_context self)
{
  (void)self;
  free(*line);
  *line = NULL;
  return mikrokopter_ether;
}


/** Codel mk_connect_open of activity connect.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_replace.
 * Throws mikrokopter_e_line.
 */
genom_event
mk_connect_open(const char device[64], uint32_t baud,
                mikrokopter_line_s **fresh, const genom_context self)
{
  *fresh = device[0] ? calloc(1, sizeof **fresh) : NULL;
  if (!*fresh) {
    mikrokopter_e_line_detail d = {.code = 0};
    snprintf(d.what, sizeof d.what, "cannot open `%.40s`", device);
    return mikrokopter_e_line(&d, self);
  }
  (*fresh)->baud = baud;
  return mikrokopter_replace;
}


/** Codel mk_connect_replace of activity connect.
 *
 * Triggered by mikrokopter_replace.
 * Yields to mikrokopter_close.
 * Throws mikrokopter_e_line.
 */
genom_event
mk_connect_replace(mikrokopter_line_s **fresh,
                   mikrokopter_line_s **line,
                   const genom_context self)
{
  (void)self;
  mikrokopter_line_s *old = *line;
  *line = *fresh;
  *fresh = old;
  return mikrokopter_close;
}


/** Codel mk_close of activity connect.
 *
 * Triggered by mikrokopter_close.
 * Yields to mikrokopter_ether.
 * Throws mikrokopter_e_line.
 */
genom_event
mk_close(mikrokopter_line_s **fresh, const genom_context self)
{
  (void)self;
  free(*fresh);
  *fresh = NULL;
  return mikrokopter_ether;
}


/** Codel mk_connect_stop of activity connect.
 *
 * Triggered by mikrokopter_stop.
 * Yields to mikrokopter_ether.
 * Throws mikrokopter_e_line.
 */
genom_event
mk_connect_stop(mikrokopter_line_s **fresh, const genom_context self)
{
  (void)self;
  free(*fresh);
  *fresh = NULL;
  return mikrokopter_ether;
}


/** Codel mk_disconnect_start of activity disconnect.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_close.
 */
genom_event
mk_disconnect_start(mikrokopter_line_s **line,
                    mikrokopter_line_s **old,
                    const genom_context self)
{
  (void)self;
  *old = *line;
  *line = NULL;
  return mikrokopter_close;
}


/** Codel mk_disconnect_stop of activity disconnect.
 *
 * Triggered by mikrokopter_stop.
 * Yields to mikrokopter_ether.
 */
genom_event
mk_disconnect_stop(mikrokopter_line_s **old, const genom_context self)
{
  (void)self;
  free(*old);
  *old = NULL;
  return mikrokopter_ether;
}
