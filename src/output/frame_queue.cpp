#include "output/frame_queue.hpp"

#include <chrono>
#include <utility>

namespace drench {

FrameQueue::FrameQueue(const std::filesystem::path& folder, const Model& model, int frames, Inspect inspect,
                       int threads)
    : writer_(folder, model, frames, threads), inspect_(std::move(inspect)) {}

FrameQueue::~FrameQueue() { join(); }

void FrameQueue::check() {
  const std::lock_guard lock(mutex_);
  rethrow();
}

void FrameQueue::wait() {
  const auto begin = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !state_; });
  waited_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  rethrow();
}

void FrameQueue::write(HostState&& state) {
  wait();
  const std::lock_guard lock(mutex_);
  if (!thread_.joinable()) {
    ending_ = false;
    thread_ = std::thread(&FrameQueue::work, this);
  }
  state_ = std::move(state);
  changed_.notify_all();
}

void FrameQueue::finish() {
  const auto begin = std::chrono::steady_clock::now();
  join();
  waited_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  rethrow();
}

std::vector<std::string> FrameQueue::said() {
  const std::lock_guard lock(mutex_);
  return std::exchange(said_, {});
}

void FrameQueue::sync() { writer_.sync(); }

void FrameQueue::join() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

/// Once only: after it the caller knows.
void FrameQueue::rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void FrameQueue::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return state_ || ending_; });
    if (!state_) return;
    lock.unlock();
    std::exception_ptr error;
    std::string said;
    try {
      writer_.write(*state_);  // nobody else touches it while it is there
      if (inspect_) said = inspect_(*state_);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    state_.reset();
    if (error) error_ = error;
    if (!said.empty()) said_.push_back(std::move(said));
    changed_.notify_all();
  }
}

}  // namespace drench
