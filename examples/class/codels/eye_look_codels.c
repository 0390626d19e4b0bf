#include "aceye.h"

#include "eye_c_types.h"

#include <math.h>
#include <string.h>

enum { radius = 4, step = 4 };  /* pixels; every fourth row is searched */


/* --- Task look -------------------------------------------------------- */


/** Codel eye_look_start of task look.
 *
 * Triggered by eye_start.
 * Yields to eye_pause_grab.
 */
genom_event
eye_look_start(uint32_t *frames, double *swing,
               const watching_ball *ball, const genom_context self)
{
  *frames = 0;
  *swing = 6.;
  *ball->data(self) = (watching_sight){ 0 };
  ball->write(self);
  return eye_pause_grab;
}


/** Codel eye_look_grab of task look.
 *
 * Triggered by eye_grab.
 * Yields to eye_find.
 */
genom_event
eye_look_grab(double swing, uint32_t *frames, uint8_t picture[3072],
              const genom_context self)
{
  const double pi = 3.14159265358979;
  const double t = 0.04 * (*frames)++;
  const int cx = lround(eye_width * (0.5 + 0.4 * sin(2. * pi * t / swing)));
  const int cy = eye_height / 2;

  (void)self;
  memset(picture, 10, eye_width * eye_height);
  for (int y = cy - radius; y <= cy + radius; y++)
    for (int x = cx - radius; x <= cx + radius; x++)
      if ((x - cx) * (x - cx) + (y - cy) * (y - cy) <= radius * radius)
        picture[y * eye_width + x] = 250;
  return eye_find;
}


/** Codel eye_look_find of task look.
 *
 * Triggered by eye_find.
 * Yields to eye_pause_grab.
 */
genom_event
eye_look_find(const uint8_t picture[3072], const watching_ball *ball,
              const genom_context self)
{
  watching_sight *sight = ball->data(self);
  long count = 0, sum = 0;

  for (int y = 0; y < eye_height; y += step)
    for (int x = 0; x < eye_width; x++)
      if (picture[y * eye_width + x] > 200) {
        count++;
        sum += x;
      }
  sight->seen = count > 0;
  sight->x = count > 0 ? 2. * sum / count / eye_width - 1. : 0.;
  ball->write(self);
  return eye_pause_grab;
}
