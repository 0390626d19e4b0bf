#include "acpom.h"

#include "pom_c_types.h"

#include <string.h>

#include "stamps.h"

/** Appends an input, in place of the oldest one if there are too many. */
static pom_input_s *
append(sequence32_pom_input_s *inputs, or_time_ts ts)
{
  if (inputs->_length >= pom_max_inputs) {
    memmove(inputs->_buffer, inputs->_buffer + 1, (pom_max_inputs - 1) * sizeof *inputs->_buffer);
    inputs->_length = pom_max_inputs - 1;
  }
  pom_input_s *input = &inputs->_buffer[inputs->_length++];
  memset(input, 0, sizeof *input);
  input->ts = ts;
  return input;
}

/* Times of the last inputs. Only codels of task io use them. */
static double last_imu, last_pose;


/** Codel pom_io_start of task io.
 *
 * Triggered by pom_start.
 * Yields to pom_poll.
 */
genom_event
pom_io_start(sequence32_pom_input_s *inputs, uint32_t *history,
             const genom_context self)
{
  (void)self;
  inputs->_length = 0;
  *history = 100;
  last_imu = last_pose = 0.;
  return pom_poll;
}


/** Codel pom_io_poll of task io.
 *
 * Triggered by pom_poll.
 * Yields to pom_pause_poll.
 */
genom_event
pom_io_poll(const pom_pose *pose, const pom_imu *imu, uint32_t history,
            sequence32_pom_input_s *inputs, const genom_context self)
{
  const quad_rotors_inertial *unit = NULL;
  if (imu->read(self) == genom_ok) unit = imu->data(self);
  if (unit && seconds(unit->ts) > last_imu) {
    last_imu = seconds(unit->ts);
    pom_input_s *input = append(inputs, unit->ts);
    input->imu._present = true;
    input->imu._value = *unit;
  }

  const or_pose_estimator_state *seen = NULL;
  if (pose->read(self) == genom_ok) seen = pose->data(self);
  if (seen && seen->pos._present && seen->att._present && seconds(seen->ts) > last_pose) {
    last_pose = seconds(seen->ts);
    if (last_pose >= last_imu - history * 1e-3) {
      pom_input_s *input = append(inputs, seen->ts);
      input->pose._present = true;
      input->pose._value = *seen;
    }
  }
  return pom_pause_poll;
}


/** Codel pom_io_stop of task io.
 *
 * Triggered by pom_stop.
 * Yields to pom_ether.
 */
genom_event
pom_io_stop(sequence32_pom_input_s *inputs, const genom_context self)
{
  (void)self;
  inputs->_length = 0;
  return pom_ether;
}
