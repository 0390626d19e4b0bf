/*
 * Vectors and unit quaternions, for the codels of this folder.
 *
 * A quaternion rotates from the body frame to the world frame.
 */
#ifndef QUAD_ATTITUDE_H
#define QUAD_ATTITUDE_H

#include <math.h>

#define GRAVITY 9.81

struct vec { double x, y, z; };
struct quat { double w, x, y, z; };

static inline struct vec
vec_sum(struct vec a, struct vec b)
{
  return (struct vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct vec
vec_times(struct vec a, double k)
{
  return (struct vec){a.x * k, a.y * k, a.z * k};
}

static inline double
vec_dot(struct vec a, struct vec b)
{
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec
vec_cross(struct vec a, struct vec b)
{
  return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double
vec_length(struct vec a)
{
  return sqrt(vec_dot(a, a));
}

static inline struct quat
quat_times(struct quat a, struct quat b)
{
  return (struct quat){
    a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
    a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
    a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

static inline struct quat
quat_inverse(struct quat a)
{
  return (struct quat){a.w, -a.x, -a.y, -a.z};
}

static inline struct quat
quat_unit(struct quat a)
{
  double n = sqrt(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z);
  if (n < 1e-9) return (struct quat){1., 0., 0., 0.};
  return (struct quat){a.w / n, a.x / n, a.y / n, a.z / n};
}

/** The rotation by a vector: its direction is the axis, its length the angle. */
static inline struct quat
quat_turn(struct vec r)
{
  double angle = vec_length(r);
  double k = angle < 1e-9 ? .5 : sin(angle / 2.) / angle;
  return (struct quat){cos(angle / 2.), k * r.x, k * r.y, k * r.z};
}

/** Turns a vector of the body frame into the world frame. */
static inline struct vec
quat_rotate(struct quat q, struct vec v)
{
  struct vec u = {q.x, q.y, q.z};
  struct vec t = vec_times(vec_cross(u, v), 2.);
  return vec_sum(vec_sum(v, vec_times(t, q.w)), vec_cross(u, t));
}

static inline double
quat_yaw(struct quat q)
{
  return atan2(2. * (q.w * q.z + q.x * q.y), 1. - 2. * (q.y * q.y + q.z * q.z));
}

static inline double
clamp(double x, double least, double greatest)
{
  return x < least ? least : x > greatest ? greatest : x;
}

#endif /* QUAD_ATTITUDE_H */
