// The angles of hinges over all their turns, which ODE keeps from step to step and no function of it sets.
#pragma once

#include <gazebo/physics/physics.hh>

namespace nrp
{
/// The angle of a joint as ODE has it after a step; a joint that is no hinge has none.
class Turns
{
public:
  explicit Turns(const gazebo::physics::JointPtr &joint);

  /// Return the angle that ODE keeps, rad; 0 without a hinge.
  double Get() const;

  /// Set it to the last bit.
  void Set(double angle) const;

  /// Set it so that the joint is at a position, rad, whose turns its bodies do not show.
  void Place(double position) const;

private:
  gazebo::physics::JointPtr joint_;
  char *kept_ = nullptr;  ///< the angle in the hinge
};
}  // namespace nrp
