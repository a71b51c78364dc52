#pragma once
// Frames written by a thread of their own while the next steps run.

#include <condition_variable>
#include <exception>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "output/vtu_series.hpp"

namespace drench {

/// Writes what FrameWriter writes, the same bytes in the same order, one frame at a time: at most one state waits or is
/// being written. Errors of the thread come out of the next call here. All calls come from one thread.
class FrameQueue {
 public:
  using Inspect = std::function<std::string(const HostState&)>;
  /// Writes what never changes, here and now. The thread starts with the first frame.
  /// `inspect` looks at each frame's state in that thread; what it says is kept for said(). `threads` as FrameWriter's.
  FrameQueue(const std::filesystem::path& folder, const Model& model, int frames = 0, Inspect inspect = {},
             int threads = 1);
  /// Writes what was handed over; its errors are lost (call finish for them).
  ~FrameQueue();
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;

  /// Throws the thread's error, if it had one. Does not wait.
  void check();
  /// Waits until nothing is being written: call it before a state is made, so that there are never two.
  void wait();
  /// Hands a frame over.
  void write(HostState&& state);
  /// Waits for the last frame, ends the thread and throws its error, if it had one.
  void finish();

  /// What `inspect` has said since the last call, a text for each frame that it said something of.
  std::vector<std::string> said();
  /// After wait() or finish(): puts what was written since the last call onto the disk itself. Throws.
  void sync();

  /// Frames on disk; after finish.
  int frames() const { return writer_.frames(); }
  std::vector<std::string> collections() const { return writer_.collections(); }
  /// s: how long callers of wait and finish waited.
  double waited() const { return waited_; }

 private:
  void work();
  void join();
  void rethrow();

  FrameWriter writer_;
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<HostState> state_;  // until it is written
  std::exception_ptr error_;
  Inspect inspect_;
  std::vector<std::string> said_;
  bool ending_ = false;
  double waited_ = 0;
};

}  // namespace drench
