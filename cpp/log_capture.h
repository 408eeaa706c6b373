// What Ceres logs, as data. The only pair of files that knows which logger Ceres uses.
#ifndef HITL_CPP_LOG_CAPTURE_H_
#define HITL_CPP_LOG_CAPTURE_H_

#include <memory>
#include <string>
#include <vector>

namespace hitl::ceres_backend {

// While it lives, warnings and errors that Ceres logs on this thread are collected; nothing reaches
// a terminal or a file. Ceres must run on one thread.
class LogCapture {
 public:
  LogCapture();
  ~LogCapture();
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  // The lines so far.
  std::vector<std::string> Lines() const;

 private:
  class Sink;
  std::unique_ptr<Sink> sink_;
};

}  // namespace hitl::ceres_backend

#endif  // HITL_CPP_LOG_CAPTURE_H_
