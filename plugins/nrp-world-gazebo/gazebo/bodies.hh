// The links and joints of a world by number, and the loads that act on them in each step.
#pragma once

#include <gazebo/physics/physics.hh>

#include <map>
#include <string>
#include <vector>

#include "turns.hh"
#include "wire.hh"

namespace nrp
{
using gazebo::physics::JointPtr;
using gazebo::physics::LinkPtr;
using ignition::math::Pose3d;
using ignition::math::Vector3d;

/// A force (N) and a torque (N m) along the axes of the world, at a point of a link, which is given in its frame.
struct Wrench
{
  Vector3d force, torque, point;
};

/// A motor: a constraint of the velocity of a joint (rad/s, m/s) with a bounded effort (N m, N).
struct Motor
{
  double velocity = 0;
  double share = 1;  ///< the share of the error of the velocity that a step removes
  double limit = 0;  ///< the largest effort; 0: there is no motor
};

/// The links and joints, numbered in the order of the world; links of static models come last.
class Bodies
{
public:
  explicit Bodies(const gazebo::physics::WorldPtr &world);

  const LinkPtr &Link(std::uint32_t number) const { return links_.at(number); }
  const JointPtr &Joint(std::uint32_t number) const { return joints_.at(number); }
  const Turns &TurnsOf(std::uint32_t joint) const { return turns_.at(joint); }
  std::uint32_t NumberOf(const gazebo::physics::Link *link) const { return numbers_.at(link); }

  /// The names of all links and joints, as JSON.
  std::string Description() const;

  void SetEffort(std::uint32_t joint, double effort);
  void SetWrench(std::uint32_t link, const Wrench &wrench);
  void SetMotor(std::uint32_t joint, const Motor &motor);
  void Release();

  /// Apply the loads of the next step; Gazebo forgets them after it.
  void Push();

  /// Set the pose of a link's frame, and its velocity.
  void Put(std::uint32_t link, const std::vector<double> &motion);

  /// Add position, orientation (x, y, z, w), linear and angular velocity of each movable link, and position,
  /// velocity and effort of each joint.
  void AddState(Writer &answer) const;

  /// Add force and torque of a joint's child on its parent, at the child's origin, along the child's axes.
  void AddJointWrench(std::uint32_t joint, Writer &answer) const;

  std::size_t Movable() const { return movable_; }
  std::size_t JointCount() const { return joints_.size(); }

private:
  void Take(const gazebo::physics::ModelPtr &model, bool fixed);
  double EffortOf(std::uint32_t joint) const;

  std::vector<LinkPtr> links_;
  std::vector<JointPtr> joints_;
  std::vector<Turns> turns_;
  std::map<const gazebo::physics::Link *, std::uint32_t> numbers_;
  std::size_t movable_ = 0;
  std::map<std::uint32_t, double> efforts_;
  std::map<std::uint32_t, Wrench> wrenches_;
  std::map<std::uint32_t, Motor> motors_;
  std::map<std::uint32_t, double> frictions_;
};
}  // namespace nrp
