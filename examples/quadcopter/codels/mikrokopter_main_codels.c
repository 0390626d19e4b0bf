#include "acmikrokopter.h"

#include "mikrokopter_c_types.h"

#include <math.h>
#include <string.h>

#include "mikrokopter_line.h"

/* Periods without new command. Only one servo runs at a time. */
static uint32_t silence;

static double
clamp(double x, double least, double greatest)
{
  return x < least ? least : x > greatest ? greatest : x;
}

static void
publish(const quad_rotors_velocities *measured, const quad_rotors_inertial *inertia,
        const mikrokopter_calibration_s *calibration, const mikrokopter_imu *imu,
        const mikrokopter_actual_velocity *actual_velocity, const genom_context self)
{
  quad_rotors_inertial *unit = imu->data(self);
  if (unit) {
    *unit = *inertia;
    unit->gyro.wx -= calibration->gyro_bias.wx;
    unit->gyro.wy -= calibration->gyro_bias.wy;
    unit->gyro.wz -= calibration->gyro_bias.wz;
    unit->accel.ax -= calibration->accel_bias.ax;
    unit->accel.ay -= calibration->accel_bias.ay;
    unit->accel.az -= calibration->accel_bias.az;
    (void)imu->write(self);
  }
  quad_rotors_velocities *velocities = actual_velocity->data(self);
  if (velocities) {
    *velocities = *measured;
    (void)actual_velocity->write(self);
  }
}


/** Codel mk_main_start of task main.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_publish.
 */
genom_event
mk_main_start(mikrokopter_calibration_s *calibration,
              mikrokopter_ids_limits_s *limits, bool *spinning,
              const mikrokopter_imu *imu,
              const mikrokopter_actual_velocity *actual_velocity,
              const mikrokopter_line_command *line_command,
              const genom_context self)
{
  memset(calibration, 0, sizeof *calibration);
  *limits = (mikrokopter_ids_limits_s){.wmin = 16., .wmax = 100., .timeout = 500};
  *spinning = false;

  quad_rotors_velocities zero = {.w = {._length = 0}};
  quad_rotors_inertial still = {.ts = {0, 0}};
  publish(&zero, &still, calibration, imu, actual_velocity, self);
  quad_rotors_velocities *out = line_command->data(self);
  if (out) *out = zero;
  return mikrokopter_publish;
}


/** Codel mk_main_publish of task main.
 *
 * Triggered by mikrokopter_publish.
 * Yields to mikrokopter_pause_publish.
 */
genom_event
mk_main_publish(const mikrokopter_line_s *line,
                const quad_rotors_velocities *measured,
                const quad_rotors_inertial *inertia,
                const mikrokopter_calibration_s *calibration,
                const mikrokopter_imu *imu,
                const mikrokopter_actual_velocity *actual_velocity,
                const mikrokopter_line_command *line_command,
                const genom_context self)
{
  publish(measured, inertia, calibration, imu, actual_velocity, self);

  /* What was written to the line goes to the motor controllers. */
  quad_rotors_velocities *out = line_command->data(self);
  if (out) {
    out->ts = measured->ts;
    out->w._length = line_rotors;
    for (int i = 0; i < line_rotors; i++) out->w._buffer[i] = line ? line->sent[i] : 0.;
    (void)line_command->write(self);
  }
  return mikrokopter_pause_publish;
}


/** Codel mk_main_stop of task main.
 *
 * Triggered by mikrokopter_stop.
 * Yields to mikrokopter_ether.
 */
genom_event
mk_main_stop(const mikrokopter_line_s *line, bool *spinning,
             const genom_context self)
{
  (void)self;
  line_send_all(line, 0.);
  *spinning = false;
  return mikrokopter_ether;
}


/** Codel mk_start_start of activity start.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_pause_wait, mikrokopter_ether.
 * Throws mikrokopter_e_not_connected.
 */
genom_event
mk_start_start(const mikrokopter_line_s *line,
               const genom_context self)
{
  if (!line) return mikrokopter_e_not_connected(self);
  line_send_all(line, line_idle);
  return mikrokopter_pause_wait;
}


/** Codel mk_start_wait of activity start.
 *
 * Triggered by mikrokopter_wait.
 * Yields to mikrokopter_pause_wait, mikrokopter_ether.
 * Throws mikrokopter_e_not_connected.
 */
genom_event
mk_start_wait(const mikrokopter_line_s *line,
              const quad_rotors_velocities *measured, bool *spinning,
              const genom_context self)
{
  if (!line) return mikrokopter_e_not_connected(self);
  for (int i = 0; i < line_rotors; i++)
    if (measured->w._length <= (uint32_t)i || measured->w._buffer[i] < .9 * line_idle)
      return mikrokopter_pause_wait;
  *spinning = true;
  return mikrokopter_ether;
}


/** Codel mk_start_stop of activity start.
 *
 * Triggered by mikrokopter_stop.
 * Yields to mikrokopter_ether.
 * Throws mikrokopter_e_not_connected.
 */
genom_event
mk_start_stop(const mikrokopter_line_s *line,
              const genom_context self)
{
  (void)self;
  line_send_all(line, 0.);
  return mikrokopter_ether;
}


/** Codel mk_servo_start of activity servo.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_command, mikrokopter_ether.
 * Throws mikrokopter_e_not_connected, mikrokopter_e_no_command.
 */
genom_event
mk_servo_start(bool spinning, quad_rotors_velocities *wanted,
               const genom_context self)
{
  if (!spinning) return mikrokopter_e_not_connected(self);
  memset(wanted, 0, sizeof *wanted);
  silence = 0;
  return mikrokopter_command;
}


/** Codel mk_servo_command of activity servo.
 *
 * Triggered by mikrokopter_command.
 * Yields to mikrokopter_send, mikrokopter_slow.
 * Throws mikrokopter_e_not_connected, mikrokopter_e_no_command.
 */
genom_event
mk_servo_command(const mikrokopter_cmd_velocity *cmd_velocity,
                 const mikrokopter_ids_limits_s *limits,
                 quad_rotors_velocities *wanted,
                 const genom_context self)
{
  const quad_rotors_velocities *c = NULL;
  if (cmd_velocity->read(self) == genom_ok) c = cmd_velocity->data(self);

  bool fresh = c && (c->ts.sec != wanted->ts.sec || c->ts.nsec != wanted->ts.nsec);
  silence = fresh ? 0 : silence + 1;
  if (silence > limits->timeout) return mikrokopter_slow;

  wanted->w._length = line_rotors;
  if (c) wanted->ts = c->ts;
  for (int i = 0; i < line_rotors; i++)
    wanted->w._buffer[i] =
      clamp(c && c->w._length > (uint32_t)i ? c->w._buffer[i] : 0., limits->wmin, limits->wmax);
  return mikrokopter_send;
}


/** Codel mk_servo_send of activity servo.
 *
 * Triggered by mikrokopter_send.
 * Yields to mikrokopter_pause_command.
 * Throws mikrokopter_e_not_connected, mikrokopter_e_no_command.
 */
genom_event
mk_servo_send(const mikrokopter_line_s *line,
              const quad_rotors_velocities *wanted,
              const genom_context self)
{
  if (!line) return mikrokopter_e_not_connected(self);
  line_send(line, wanted);
  return mikrokopter_pause_command;
}


/** Codel mk_servo_slow of activity servo.
 *
 * Triggered by mikrokopter_slow.
 * Yields to mikrokopter_pause_slow, mikrokopter_stop.
 * Throws mikrokopter_e_not_connected, mikrokopter_e_no_command.
 */
genom_event
mk_servo_slow(const mikrokopter_line_s *line,
              const quad_rotors_velocities *measured,
              const mikrokopter_ids_limits_s *limits,
              quad_rotors_velocities *wanted,
              const genom_context self)
{
  if (!line) return mikrokopter_e_not_connected(self);
  bool slowest = true;
  for (int i = 0; i < line_rotors; i++) {
    double *w = &wanted->w._buffer[i];
    *w = clamp(*w - .02, limits->wmin, limits->wmax);
    if (measured->w._length > (uint32_t)i && measured->w._buffer[i] > 1.1 * limits->wmin)
      slowest = false;
  }
  wanted->w._length = line_rotors;
  line_send(line, wanted);
  return slowest ? mikrokopter_stop : mikrokopter_pause_slow;
}


/** Codel mk_servo_stop of activity servo.
 *
 * Triggered by mikrokopter_stop.
 * Yields to mikrokopter_ether.
 * Throws mikrokopter_e_not_connected, mikrokopter_e_no_command.
 */
genom_event
mk_servo_stop(const mikrokopter_line_s *line,
              const genom_context self)
{
  (void)self;
  /* Function stop may have sent 0 before. */
  if (line && line->sent[0] > 0.) line_send_all(line, line_idle);
  return mikrokopter_ether;
}


/** Codel mk_calibrate_start of activity calibrate_imu.
 *
 * Triggered by mikrokopter_start.
 * Yields to mikrokopter_collect.
 * Throws mikrokopter_e_range.
 */
genom_event
mk_calibrate_start(mikrokopter_calibration_s *sum, uint32_t *samples,
                   const genom_context self)
{
  (void)self;
  memset(sum, 0, sizeof *sum);
  *samples = 0;
  return mikrokopter_collect;
}


/** Codel mk_calibrate_collect of activity calibrate_imu.
 *
 * Triggered by mikrokopter_collect.
 * Yields to mikrokopter_pause_collect, mikrokopter_done.
 * Throws mikrokopter_e_range.
 */
genom_event
mk_calibrate_collect(const quad_rotors_inertial *inertia,
                     double duration, mikrokopter_calibration_s *sum,
                     uint32_t *samples, const genom_context self)
{
  (void)self;
  sum->gyro_bias.wx += inertia->gyro.wx;
  sum->gyro_bias.wy += inertia->gyro.wy;
  sum->gyro_bias.wz += inertia->gyro.wz;
  sum->accel_bias.ax += inertia->accel.ax;
  sum->accel_bias.ay += inertia->accel.ay;
  sum->accel_bias.az += inertia->accel.az;
  (*samples)++;
  return *samples * 1e-3 >= duration ? mikrokopter_done : mikrokopter_pause_collect;
}


/** Codel mk_calibrate_done of activity calibrate_imu.
 *
 * Triggered by mikrokopter_done.
 * Yields to mikrokopter_ether.
 * Throws mikrokopter_e_range.
 */
genom_event
mk_calibrate_done(const mikrokopter_calibration_s *sum,
                  uint32_t samples,
                  mikrokopter_calibration_s *calibration,
                  const genom_context self)
{
  (void)self;
  double n = samples;
  calibration->gyro_bias =
    (or_t3d_avel){sum->gyro_bias.wx / n, sum->gyro_bias.wy / n, sum->gyro_bias.wz / n};
  /* Gravity is no bias. */
  calibration->accel_bias = (or_t3d_acc){sum->accel_bias.ax / n, sum->accel_bias.ay / n,
                                         sum->accel_bias.az / n - 9.81};
  return mikrokopter_ether;
}
