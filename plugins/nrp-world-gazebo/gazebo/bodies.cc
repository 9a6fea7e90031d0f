#include "bodies.hh"

#include <sstream>

namespace nrp
{
namespace
{
std::string Quoted(const std::string &text)
{
  std::string quoted = "\"";
  for (const char each : text)
  {
    if (each == '"' || each == '\\')
      quoted += '\\';
    quoted += each;
  }
  return quoted + '"';
}

template <typename Things> std::string Names(const Things &things)
{
  std::ostringstream names;
  for (const auto &thing : things)
    names << (names.tellp() ? "," : "") << Quoted(thing->GetScopedName());
  return "[" + names.str() + "]";
}
}  // namespace

Bodies::Bodies(const gazebo::physics::WorldPtr &world)
{
  for (const auto &model : world->Models())
    Take(model, false);
  movable_ = links_.size();
  for (const auto &model : world->Models())
    Take(model, true);
  turns_ = std::vector<Turns>(joints_.begin(), joints_.end());
  for (std::uint32_t number = 0; number < links_.size(); ++number)
    numbers_[links_[number].get()] = number;
}

void Bodies::Take(const gazebo::physics::ModelPtr &model, bool fixed)
{
  if (model->IsStatic() == fixed)
  {
    for (const auto &link : model->GetLinks())
      links_.push_back(link);
    if (!fixed)
      for (const auto &joint : model->GetJoints())
        joints_.push_back(joint);
  }
  for (const auto &inner : model->NestedModels())
    Take(inner, fixed);
}

std::string Bodies::Description() const
{
  return "\"movable\":" + std::to_string(movable_) + ",\"links\":" + Names(links_) + ",\"joints\":" + Names(joints_);
}

void Bodies::SetEffort(std::uint32_t joint, double effort)
{
  Joint(joint);
  efforts_[joint] = effort;
  if (effort == 0.0)
    efforts_.erase(joint);
}

void Bodies::SetWrench(std::uint32_t link, const Wrench &wrench)
{
  Link(link);
  wrenches_[link] = wrench;
  if (wrench.force == Vector3d::Zero && wrench.torque == Vector3d::Zero)
    wrenches_.erase(link);
}

void Bodies::SetMotor(std::uint32_t number, const Motor &motor)
{
  const JointPtr &joint = Joint(number);
  const bool known = motors_.count(number);
  if (!known)
    frictions_.emplace(number, joint->GetParam("fmax", 0));
  if (motor.limit == 0)
  {
    motors_.erase(number);
    joint->SetParam("vel", 0, 0.0);
    joint->SetParam("fmax", 0, frictions_[number]);
    return;
  }
  motors_[number] = motor;
  joint->SetProvideFeedback(true);  // the effort of a motor is read from the load of its joint
  joint->SetParam("vel", 0, motor.velocity);
  joint->SetParam("fmax", 0, motor.limit);
}

void Bodies::Release()
{
  efforts_.clear();
  wrenches_.clear();
  const auto motors = motors_;
  for (const auto &each : motors)
    SetMotor(each.first, Motor());
}

void Bodies::Push()
{
  for (const auto &each : motors_)
  {
    const Motor &motor = each.second;
    const JointPtr &joint = joints_[each.first];
    if (motor.share < 1)
      joint->SetParam("vel", 0, joint->GetVelocity(0) * (1 - motor.share) + motor.share * motor.velocity);
  }
  for (const auto &each : efforts_)
    joints_[each.first]->SetForce(0, each.second);
  for (const auto &each : wrenches_)
  {
    const auto &[force, torque, point] = each.second;
    const LinkPtr &link = links_[each.first];
    const Vector3d at = link->WorldPose().Pos() + link->WorldPose().Rot() * point;
    link->AddForce(force);
    link->AddTorque(torque + (at - link->WorldCoGPose().Pos()).Cross(force));
  }
}

double Bodies::EffortOf(std::uint32_t number) const
{
  if (motors_.count(number) == 0)
  {
    const auto given = efforts_.find(number);
    return given == efforts_.end() ? 0.0 : given->second;
  }
  const auto &joint = *joints_[number];
  const auto wrench = joints_[number]->GetForceTorque(0u);
  const Vector3d axis = joint.GetChild()->WorldPose().Rot().RotateVectorReverse(joint.GlobalAxis(0));
  const bool slides = joint.HasType(gazebo::physics::Base::SLIDER_JOINT);
  return axis.Dot(slides ? wrench.body2Force : wrench.body2Torque);
}

void Bodies::Put(std::uint32_t number, const std::vector<double> &m)
{
  const LinkPtr &link = Link(number);
  link->SetWorldPose(Pose3d(m[0], m[1], m[2], m[6], m[3], m[4], m[5]));
  const Vector3d linear(m[7], m[8], m[9]), angular(m[10], m[11], m[12]);
  const Vector3d arm = link->WorldCoGPose().Pos() - link->WorldPose().Pos();
  link->SetLinearVel(linear + angular.Cross(arm));
  link->SetAngularVel(angular);
}

void Bodies::AddState(Writer &answer) const
{
  for (std::size_t number = 0; number < movable_; ++number)
  {
    const auto &link = *links_[number];
    const Pose3d &pose = link.WorldPose();
    const Vector3d angular = link.WorldAngularVel();
    const Vector3d linear = link.WorldCoGLinearVel() - angular.Cross(link.WorldCoGPose().Pos() - pose.Pos());
    const double row[] = {pose.Pos().X(), pose.Pos().Y(), pose.Pos().Z(), pose.Rot().X(), pose.Rot().Y(),
                          pose.Rot().Z(), pose.Rot().W(), linear.X(), linear.Y(), linear.Z(),
                          angular.X(), angular.Y(), angular.Z()};
    answer.Add(row, 13);
  }
  for (std::uint32_t number = 0; number < joints_.size(); ++number)
  {
    const auto &joint = *joints_[number];
    double row[] = {0, 0, 0};
    if (joint.DOF() == 1)
    {
      row[0] = joint.Position(0);
      row[1] = joint.GetVelocity(0);
      row[2] = EffortOf(number);
    }
    answer.Add(row, 3);
  }
}

void Bodies::AddJointWrench(std::uint32_t number, Writer &answer) const
{
  const JointPtr &joint = Joint(number);
  joint->SetProvideFeedback(true);
  const auto wrench = joint->GetForceTorque(0u);
  const double row[] = {wrench.body2Force.X(), wrench.body2Force.Y(), wrench.body2Force.Z(),
                        wrench.body2Torque.X(), wrench.body2Torque.Y(), wrench.body2Torque.Z()};
  answer.Add(row, 6);
}
}  // namespace nrp
