// SPDX-License-Identifier: MIT
#include "tests/support/mjpeg_server.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

namespace airclay {
namespace {

bool sendAll(int client, const std::string& bytes) {
  return send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

}  // namespace

MjpegServer::MjpegServer(ImageSize size, double rate_hz, int port) {
  listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t length = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  if (bind(listening_, any, length) != 0 || listen(listening_, 4) != 0 ||
      getsockname(listening_, any, &length) != 0)
    throw std::runtime_error("no port for the test's camera");
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this, size, rate_hz] { serve(size, rate_hz); });
}

MjpegServer::~MjpegServer() {
  ending_ = true;
  thread_.join();
  close(listening_);
}

void MjpegServer::serve(ImageSize size, double rate_hz) {
  for (int grey = 0; !ending_;) {
    pollfd waiting{listening_, POLLIN, 0};
    if (poll(&waiting, 1, 20) <= 0) continue;
    const int client = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
    bool there =
        sendAll(client, "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n");
    while (there && !ending_) {
      std::vector<unsigned char> jpeg;
      cv::imencode(".jpg", cv::Mat(size.height, size.width, CV_8UC3, cv::Scalar::all(++grey & 255)), jpeg);
      there = sendAll(client,
                      "--next\r\nContent-Type: image/jpeg\r\nContent-Length: " + std::to_string(jpeg.size()) +
                          "\r\n\r\n" + std::string(jpeg.begin(), jpeg.end()) + "\r\n");
      std::this_thread::sleep_for(std::chrono::duration<double>(1 / rate_hz));
    }
    close(client);
  }
}

}  // namespace airclay
