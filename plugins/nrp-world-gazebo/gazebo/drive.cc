#include "drive.hh"

#include <algorithm>

namespace nrp
{
Drive::Drive(Bodies &bodies, Reader &request) : bodies_(bodies), link_(request.Next<std::uint32_t>())
{
  const auto f = request.Doubles(7), c = request.Doubles(6);
  frame_ = Pose3d(f[0], f[1], f[2], f[6], f[3], f[4], f[5]);
  centre_ = Vector3d(c[0], c[1], c[2]);
  lever_ = c[3];
  gain_ = c[4];
  limit_ = c[5];
  bodies_.Link(link_);
}

void Drive::Aim(Reader &request)
{
  left_ = request.Next<double>();
  right_ = request.Next<double>();
  front_ = request.Next<double>();
  rear_ = request.Next<double>();
}

void Drive::Push(const Vector3d &fall)
{
  if (limit_ == 0)
    return;  // the wheels move the robot, or it has no traction
  const LinkPtr &link = bodies_.Link(link_);
  const auto turn = link->WorldPose().Rot() * frame_.Rot();
  const auto cog = link->WorldCoGPose().Pos();
  const Vector3d centre = link->WorldPose().Pos() + link->WorldPose().Rot() * (frame_.Pos() + frame_.Rot() * centre_);
  const Vector3d angular = link->WorldAngularVel();
  const Vector3d moved = link->WorldCoGLinearVel() + angular.Cross(centre - cog) + fall;
  const Vector3d velocity = turn.RotateVectorReverse(moved);
  const double swing = lever_ * turn.RotateVectorReverse(angular).Z();
  const auto force = [this](double error) { return std::clamp(gain_ * error, -limit_, limit_); };
  const double left = force(left_ - velocity.X() + swing), right = force(right_ - velocity.X() - swing);
  const double front = force(front_ - velocity.Y() - swing), rear = force(rear_ - velocity.Y() + swing);
  const Vector3d pull = turn * Vector3d(left + right, front + rear, 0);
  const Vector3d twist = turn * Vector3d(0, 0, lever_ * (right - left + front - rear));
  link->AddForce(pull);
  link->AddTorque(twist + (centre - cog).Cross(pull));
}
}  // namespace nrp
