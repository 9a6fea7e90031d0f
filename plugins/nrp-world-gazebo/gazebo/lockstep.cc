// A world plugin that steps Gazebo only when asked, over a Unix socket.
//
// Everything happens in the thread of the physics, between two steps: it waits for a frame, carries out its
// operations in order, and answers. An operation that takes steps lets the physics run and continues after them.
#include <gazebo/common/common.hh>
#include <gazebo/gazebo_config.h>

#include <cstdlib>
#include <functional>
#include <memory>

#include "cameras.hh"
#include "commands.hh"
#include "contacts.hh"
#include "drive.hh"
#include "rays.hh"
#include "state.hh"

namespace nrp
{
class Lockstep : public gazebo::WorldPlugin
{
public:
  void Load(gazebo::physics::WorldPtr world, sdf::ElementPtr sdf) override
  {
    world_ = world;
    path_ = sdf->Get<std::string>("socket");
    if (sdf->HasElement("images"))
      cameras_ = std::make_unique<Cameras>(world, sdf->Get<std::string>("images"));
    begin_ = gazebo::event::Events::ConnectWorldUpdateBegin(std::bind(&Lockstep::OnBegin, this));
    end_ = gazebo::event::Events::ConnectWorldUpdateEnd(std::bind(&Lockstep::OnEnd, this));
  }

private:
  void OnBegin()
  {
    if (!channel_)
      Open();
    if (steps_ == 0)
      Serve();
    const Vector3d fall = world_->Gravity() * world_->Physics()->GetMaxStepSize();
    for (auto &drive : drives_)
      drive.Push(fall);
    bodies_->Push();
  }

  void OnEnd()
  {
    if (channel_ && --steps_ == 0)
      Serve();
  }

  void Open()
  {
    try
    {
      channel_ = std::make_unique<Channel>(path_);
    }
    catch (const Ended &problem)
    {
      Quit(problem);
    }
    bodies_ = std::make_unique<Bodies>(world_);
    commands_ = std::make_unique<Commands>(world_);
    world_->Physics()->GetContactManager()->SetNeverDropContacts(true);
    SteadyContacts(world_);
    for (const auto &model : world_->Models())
      model->SetAutoDisable(false);
  }

  /// Carry out operations until one takes steps.
  void Serve()
  {
    try
    {
      while (steps_ == 0)
      {
        if (request_.AtEnd())
        {
          if (asked_)
            channel_->Send(false, answer_.bytes);
          answer_.bytes.clear();
          request_ = channel_->Receive();
          asked_ = true;
          continue;
        }
        Do(static_cast<char>(request_.Next<std::uint8_t>()));
      }
    }
    catch (const Ended &problem)
    {
      Quit(problem);
    }
    catch (const std::exception &problem)
    {
      const std::string text = problem.what();
      Fail(text);
    }
  }

  void Fail(const std::string &text)
  {
    request_ = Reader();
    answer_.bytes.clear();
    asked_ = false;
    try
    {
      channel_->Send(true, std::vector<char>(text.begin(), text.end()));
    }
    catch (const Ended &problem)
    {
      Quit(problem);
    }
    Serve();
  }

  void Do(char operation)
  {
    switch (operation)
    {
      case 'h': return Greet(request_.Next<std::uint32_t>());
      case 's': steps_ = request_.Next<std::uint32_t>(); return;
      case 'x': return bodies_->AddState(answer_);
      case 'c': return AddContacts(world_, *bodies_, answer_);
      case 'b': return AddScan(world_, *bodies_, request_, answer_);
      case 'v': return commands_->Send(request_);
      case 'q': return bodies_->AddJointWrench(request_.Next<std::uint32_t>(), answer_);
      case 'd': drives_.emplace_back(*bodies_, request_); return;
      case 'a': return drives_.at(request_.Next<std::uint32_t>()).Aim(request_);
      case 'C': return Eyes().Add(*bodies_, request_);
      case 'i': return Eyes().Draw(*bodies_, request_.Next<std::uint32_t>());
      case 'k': return Eyes().Paint(request_);
      case 'l': return Eyes().Light(request_);
      case 'S': return AddSaved(*bodies_, answer_);
      case 'R': return nrp::Restore(*bodies_, request_);
      case 'r': return bodies_->Release();
      case 'e': case 'w': case 'm': case 'p': case 'j': return Load(operation, request_.Next<std::uint32_t>());
      default: throw std::runtime_error(std::string("there is no operation '") + operation + "'");
    }
  }

  void Load(char operation, std::uint32_t number)
  {
    if (operation == 'e')
      return bodies_->SetEffort(number, request_.Next<double>());
    if (operation == 'j')
      return bodies_->TurnsOf(number).Place(request_.Next<double>());
    const auto row = request_.Doubles(operation == 'p' ? 13 : operation == 'm' ? 3 : 9);
    if (operation == 'w')
      bodies_->SetWrench(number, Wrench{Vector3d(row[0], row[1], row[2]), Vector3d(row[3], row[4], row[5]),
                                        Vector3d(row[6], row[7], row[8])});
    else if (operation == 'm')
      bodies_->SetMotor(number, Motor{row[0], row[1], row[2]});
    else
      bodies_->Put(number, row);
  }

  Cameras &Eyes()
  {
    if (!cameras_)
      throw std::runtime_error("Gazebo was started without a renderer");
    return *cameras_;
  }

  void Greet(std::uint32_t version)
  {
    if (version != kVersion)
      throw std::runtime_error("the plugin in Gazebo speaks version " + std::to_string(kVersion) +
                               " of the protocol, not " + std::to_string(version));
    answer_.Add("{\"gazebo\":\"" + std::string(GAZEBO_VERSION_FULL) + "\"," + bodies_->Description() + "}");
  }

  /// End the process: without its engine it has no purpose, and a regular end waits for this thread.
  [[noreturn]] void Quit(const Ended &)
  {
    std::_Exit(0);
  }

  gazebo::physics::WorldPtr world_;
  gazebo::event::ConnectionPtr begin_, end_;
  std::string path_;
  std::unique_ptr<Channel> channel_;
  std::unique_ptr<Bodies> bodies_;
  std::unique_ptr<Cameras> cameras_;
  std::unique_ptr<Commands> commands_;
  std::vector<Drive> drives_;
  Reader request_;
  Writer answer_;
  bool asked_ = false;
  std::uint32_t steps_ = 0;
};

}  // namespace nrp

using nrp::Lockstep;  // the macro belongs into the global namespace
GZ_REGISTER_WORLD_PLUGIN(Lockstep)
