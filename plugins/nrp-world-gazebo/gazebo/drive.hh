// The planar servo, which moves a robot's body as commanded; nrp_core's engine_kit/planar_servo.py defines it.
#pragma once

#include "bodies.hh"

namespace nrp
{
/// The servo of one drive. The frame of its link looks along x, to the left along y.
class Drive
{
public:
  Drive(Bodies &bodies, Reader &request);

  void Aim(Reader &request);

  /// Set the forces of the next step.
  void Push(const Vector3d &fall);

private:
  Bodies &bodies_;
  std::uint32_t link_;
  Pose3d frame_;         ///< the body's frame in the link's
  Vector3d centre_;      ///< the robot's centre of mass in the body's frame, m
  double lever_, gain_, limit_;
  double left_ = 0, right_ = 0, front_ = 0, rear_ = 0;  ///< aims of the four points, m/s
};
}  // namespace nrp
