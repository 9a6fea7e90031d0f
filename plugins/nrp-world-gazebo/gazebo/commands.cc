#include "commands.hh"

#include <gazebo/msgs/msgs.hh>

namespace nrp
{
Commands::Commands(const gazebo::physics::WorldPtr &world) : node_(new gazebo::transport::Node())
{
  node_->Init(world->Name());
}

void Commands::Send(Reader &request)
{
  const std::string model = request.Text();
  const auto forward = request.Next<double>(), turn = request.Next<double>();
  auto &publisher = publishers_[model];
  if (!publisher)
    publisher = node_->Advertise<gazebo::msgs::Pose>("~/" + model + "/vel_cmd");
  gazebo::msgs::Pose command;
  gazebo::msgs::Set(&command, Pose3d(forward, 0, 0, 0, 0, turn));
  publisher->Publish(command, true);
  gazebo::transport::TopicManager::Instance()->ProcessNodes();
}
}  // namespace nrp
