#include "state.hh"

#include <gazebo/ode/ode.h>
#include <gazebo/physics/ode/ODELink.hh>

namespace nrp
{
namespace
{
dBodyID BodyOf(const LinkPtr &link)
{
  const auto ode = boost::dynamic_pointer_cast<gazebo::physics::ODELink>(link);
  if (!ode)
    throw std::runtime_error("states are saved with the physics engine 'ode' only");
  return ode->GetODEId();
}
/// Set the orientation without the normalisation of dBodySetQuaternion, which can change the last bit.
void SetTurn(dBodyID body, const double *turn)
{
  dBodySetQuaternion(body, turn);
  std::memcpy(const_cast<dReal *>(dBodyGetQuaternion(body)), turn, 4 * sizeof(dReal));
  dRfromQ(const_cast<dReal *>(dBodyGetRotation(body)), turn);
}
}  // namespace

void AddSaved(const Bodies &bodies, Writer &answer)
{
  answer.Add(static_cast<std::uint64_t>(dRandGetSeed()));
  for (std::uint32_t number = 0; number < bodies.Movable(); ++number)
  {
    const dBodyID body = BodyOf(bodies.Link(number));
    answer.Add(dBodyGetPosition(body), 3);
    answer.Add(dBodyGetQuaternion(body), 4);
    answer.Add(dBodyGetLinearVel(body), 3);
    answer.Add(dBodyGetAngularVel(body), 3);
  }
  for (std::uint32_t number = 0; number < bodies.JointCount(); ++number)
    answer.Add(bodies.TurnsOf(number).Get());
}

void Restore(const Bodies &bodies, Reader &saved)
{
  dRandSetSeed(static_cast<unsigned long>(saved.Next<std::uint64_t>()));
  for (std::uint32_t number = 0; number < bodies.Movable(); ++number)
  {
    const LinkPtr &link = bodies.Link(number);
    const dBodyID body = BodyOf(link);
    const auto row = saved.Doubles(13);
    // as ODELink does it after a step, so that the last bit agrees
    const Vector3d centre(row[0], row[1], row[2]);
    const ignition::math::Quaterniond turn(row[3], row[4], row[5], row[6]);
    link->SetWorldPose(Pose3d(centre - turn.RotateVector(link->GetInertial()->CoG()), turn));
    dBodySetPosition(body, row[0], row[1], row[2]);
    SetTurn(body, &row[3]);
    dBodySetLinearVel(body, row[7], row[8], row[9]);
    dBodySetAngularVel(body, row[10], row[11], row[12]);
    dBodySetForce(body, 0, 0, 0);
    dBodySetTorque(body, 0, 0, 0);
    dBodyEnable(body);
  }
  for (std::uint32_t number = 0; number < bodies.JointCount(); ++number)
    bodies.TurnsOf(number).Set(saved.Next<double>());
}
}  // namespace nrp
