#include "wire.hh"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>

namespace nrp
{
Channel::Channel(const std::string &path) : socket_(::socket(AF_UNIX, SOCK_STREAM, 0))
{
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path))
    throw Ended("the path of the socket is too long: " + path);
  path.copy(address.sun_path, path.size());
  if (::connect(socket_, reinterpret_cast<sockaddr *>(&address), sizeof(address)) != 0)
    throw Ended("cannot connect to " + path + ": " + std::strerror(errno));
}

Channel::~Channel()
{
  ::close(socket_);
}

Reader Channel::Receive()
{
  std::uint32_t size = 0;
  ReadAll(reinterpret_cast<char *>(&size), sizeof(size));
  std::vector<char> bytes(size);
  ReadAll(bytes.data(), size);
  return Reader(std::move(bytes));
}

void Channel::Send(bool failed, const std::vector<char> &bytes)
{
  const auto size = static_cast<std::uint32_t>(bytes.size() + 1);
  std::vector<char> frame(sizeof(size) + size);
  std::memcpy(frame.data(), &size, sizeof(size));
  frame[sizeof(size)] = failed ? 1 : 0;
  if (!bytes.empty())
    std::memcpy(frame.data() + sizeof(size) + 1, bytes.data(), bytes.size());
  for (std::size_t sent = 0; sent < frame.size();)
  {
    const ssize_t now = ::send(socket_, frame.data() + sent, frame.size() - sent, MSG_NOSIGNAL);
    if (now < 0 && errno == EINTR)
      continue;
    if (now <= 0)
      throw Ended("the other side has ended");
    sent += static_cast<std::size_t>(now);
  }
}

void Channel::ReadAll(char *to, std::size_t size)
{
  while (size)
  {
    const ssize_t now = ::read(socket_, to, size);
    if (now < 0 && errno == EINTR)
      continue;
    if (now <= 0)
      throw Ended("the other side has ended");
    to += now;
    size -= static_cast<std::size_t>(now);
  }
}
}  // namespace nrp
