#include "turns.hh"

#include <gazebo/ode/ode.h>
#include <gazebo/physics/ode/ODEJoint.hh>

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace nrp
{
namespace
{
constexpr double kTurn = 2 * M_PI;

/// Gives access to the hinge of a joint.
struct Opened : gazebo::physics::ODEJoint
{
  static dJointID Of(const gazebo::physics::ODEJoint &joint) { return joint.*(&Opened::jointId); }
};

/// Find the angle in the memory of a hinge, by a hinge that stands at a known angle.
std::size_t FindPlace()
{
  constexpr std::size_t kLargest = 480;  // bytes, the size of a hinge
  constexpr double kSame = 1e-9;
  const dWorldID world = dWorldCreate();
  const dBodyID body = dBodyCreate(world);
  const dJointID hinge = dJointCreateHinge(world, nullptr);
  dJointAttach(hinge, body, nullptr);
  dJointSetHingeAxis(hinge, 0, 0, 1);
  dMatrix3 turned;
  dRFromAxisAndAngle(turned, 0, 0, 1, 0.7);
  dBodySetRotation(body, turned);
  dWorldStep(world, 0.001);
  const double angle = dJointGetHingeAngle(hinge), more = angle + 2 * kTurn;
  char *const bytes = reinterpret_cast<char *>(hinge);
  std::size_t found = 0;
  for (std::size_t place = 0; !found && place < kLargest; place += sizeof(double))
  {
    double held;
    std::memcpy(&held, bytes + place, sizeof(held));
    if (!(std::abs(held - angle) < kSame))
      continue;
    std::memcpy(bytes + place, &more, sizeof(more));
    if (std::abs(dJointGetHingeAngle(hinge) - more) < kSame)
      found = place;
  }
  dWorldDestroy(world);
  if (!found)
    throw std::runtime_error("this build of ODE keeps the angle of a hinge at an unknown place");
  return found;
}
}  // namespace

Turns::Turns(const gazebo::physics::JointPtr &joint) : joint_(joint)
{
  const auto ode = boost::dynamic_pointer_cast<gazebo::physics::ODEJoint>(joint);
  if (!ode || dJointGetType(Opened::Of(*ode)) != dJointTypeHinge)
    return;
  static const std::size_t place = FindPlace();
  kept_ = reinterpret_cast<char *>(Opened::Of(*ode)) + place;
}

double Turns::Get() const
{
  double angle = 0;
  if (kept_)
    std::memcpy(&angle, kept_, sizeof(angle));
  return angle;
}

void Turns::Set(double angle) const
{
  if (kept_)
    std::memcpy(kept_, &angle, sizeof(angle));
}

void Turns::Place(double position) const
{
  if (!kept_)
    return;
  Set(position);
  const double shown = joint_->Position(0);
  if (std::abs(shown + position) < std::abs(shown - position))
    Set(-position);  // the hinge was attached the other way round
}
}  // namespace nrp
