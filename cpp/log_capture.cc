#include "log_capture.h"

#include <glog/logging.h>

#include <mutex>
#include <thread>

namespace hitl::ceres_backend {
namespace {

// A host program that has set up glog keeps its own settings.
void InitialiseOnce() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (google::IsGoogleLoggingInitialized()) return;
    // Settings from the environment (GLOG_logtostderr and the like) do not apply to a library that
    // must be silent.
    FLAGS_logtostderr = false;
    FLAGS_alsologtostderr = false;
    // At verbosity 2 Ceres lets CHOLMOD print its statistics to stdout.
    FLAGS_v = 0;
    FLAGS_vmodule = "";
    google::InitGoogleLogging("hitl");
    for (const auto severity :
         {google::GLOG_INFO, google::GLOG_WARNING, google::GLOG_ERROR, google::GLOG_FATAL}) {
      // An empty name: no file. Without this, glog leaves files in the folder for temporary ones.
      google::SetLogDestination(severity, "");
    }
    google::SetStderrLogging(google::GLOG_FATAL);
  });
}

}  // namespace

class LogCapture::Sink : public google::LogSink {
 public:
  Sink() {
    InitialiseOnce();
    google::AddLogSink(this);
  }
  ~Sink() override { google::RemoveLogSink(this); }

  using google::LogSink::send;
  void send(google::LogSeverity severity, const char* /*full_filename*/,
            const char* /*base_filename*/, int /*line*/, const google::LogMessageTime& /*time*/,
            const char* message, size_t length) override {
    if (severity < google::GLOG_WARNING || std::this_thread::get_id() != owner_) return;
    if (lines_.size() < kMostLines) lines_.emplace_back(message, length);
  }

  const std::vector<std::string>& Lines() const { return lines_; }

 private:
  // A solve that fails at every step would otherwise say so thousands of times.
  static constexpr size_t kMostLines = 20;

  // A solve logs on the thread that called it, so that no lock is needed: other solves have sinks
  // of their own.
  const std::thread::id owner_ = std::this_thread::get_id();
  std::vector<std::string> lines_;
};

LogCapture::LogCapture() : sink_(std::make_unique<Sink>()) {}
LogCapture::~LogCapture() = default;

std::vector<std::string> LogCapture::Lines() const { return sink_->Lines(); }

}  // namespace hitl::ceres_backend
