// Commands to the drives that are plugins of Gazebo itself.
#pragma once

#include <gazebo/transport/transport.hh>

#include "bodies.hh"

namespace nrp
{
/// Sends velocities to models, on the topic that Gazebo's DiffDrivePlugin and SkidSteerDrivePlugin read.
class Commands
{
public:
  explicit Commands(const gazebo::physics::WorldPtr &world);

  /// Send a command, and wait until all plugins of this process have it.
  void Send(Reader &request);

private:
  gazebo::transport::NodePtr node_;
  std::map<std::string, gazebo::transport::PublisherPtr> publishers_;
};
}  // namespace nrp
