#include <fmt/format.h>

#include "parallel/communicator.hpp"

#ifdef DRENCH_HAS_MPI
#define OMPI_SKIP_MPICXX 1  // C++ classes of a library that does not come along
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#endif

namespace drench {

#ifdef DRENCH_HAS_MPI

namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 30;  // of one message: MPI counts in int
constexpr int tag = 7;

void check(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw RanksError(fmt::format("MPI: {} failed: {}", what, std::string(text, static_cast<std::size_t>(length))));
}

/// Sums and maxima in one element of a message, which no library cuts: its first word is the number of sums, its second
/// the number of words in all.
void add_and_compare(void* from, void* to, int* length, MPI_Datatype*) {
  const auto* in = static_cast<const std::int64_t*>(from);
  auto* out = static_cast<std::int64_t*>(to);
  for (int e = 0; e < *length; ++e, in += in[1], out += out[1])
    for (std::int64_t k = 2; k < in[1]; ++k) {
      if (k < 2 + in[0]) {
        out[k] += in[k];
        continue;
      }
      double a = 0, b = 0;
      std::memcpy(&a, in + k, sizeof a);
      std::memcpy(&b, out + k, sizeof b);
      if (a > b || std::isnan(a)) std::memcpy(out + k, &a, sizeof a);
    }
}

/// Adds the time that it lives to a sum, s.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum) {}
  ~Stopwatch() { sum_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& sum_;
  Clock::time_point begin_ = Clock::now();
};

class MpiCommunicator final : public Communicator {
 public:
  MpiCommunicator() {
    int begun = 0;
    MPI_Initialized(&begun);
    if (!begun) {
      int provided = 0;
      check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
      ends_ = true;
    }
    check(MPI_Comm_dup(MPI_COMM_WORLD, &all_), "MPI_Comm_dup");
    MPI_Comm_set_errhandler(all_, MPI_ERRORS_RETURN);
    MPI_Comm_rank(all_, &rank_);
    MPI_Comm_size(all_, &size_);
    check(MPI_Op_create(add_and_compare, 1, &both_), "MPI_Op_create");
  }
  ~MpiCommunicator() override {
    for (auto& [words, type] : types_) MPI_Type_free(&type.type);
    MPI_Op_free(&both_);
    MPI_Comm_free(&all_);
    int ended = 0;
    MPI_Finalized(&ended);
    if (ends_ && !ended) MPI_Finalize();
  }
  MpiCommunicator(const MpiCommunicator&) = delete;
  MpiCommunicator& operator=(const MpiCommunicator&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  std::string description() const override { return transport_description(); }

  void all_reduce(std::span<std::int64_t> sums, std::span<double> maxima) const override {
    if (sums.empty() && maxima.empty()) return;
    const Stopwatch watch(traffic_.summing);
    ++traffic_.sums;
    if (maxima.empty()) {
      check(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_INT64_T, MPI_SUM, all_),
            "MPI_Allreduce");
      return;
    }
    std::vector<std::int64_t> words(2 + sums.size() + maxima.size());
    words[0] = static_cast<std::int64_t>(sums.size());
    words[1] = static_cast<std::int64_t>(words.size());
    std::int64_t* const first_maximum = words.data() + 2 + sums.size();
    std::copy(sums.begin(), sums.end(), words.begin() + 2);
    if (!maxima.empty()) std::memcpy(first_maximum, maxima.data(), maxima.size_bytes());
    check(MPI_Allreduce(MPI_IN_PLACE, words.data(), 1, words_of(words.size()), both_, all_), "MPI_Allreduce");
    std::copy_n(words.begin() + 2, sums.size(), sums.begin());
    if (!maxima.empty()) std::memcpy(maxima.data(), first_maximum, maxima.size_bytes());
  }
  void all_or(void* data, std::size_t bytes) const override {
    const Stopwatch watch(traffic_.summing);
    ++traffic_.sums;
    auto* at = static_cast<std::byte*>(data);
    for (std::size_t done = 0; done < bytes; done += most_bytes)
      check(MPI_Allreduce(MPI_IN_PLACE, at + done, static_cast<int>(std::min(most_bytes, bytes - done)), MPI_BYTE,
                          MPI_BOR, all_),
            "MPI_Allreduce");
  }
  std::vector<std::byte> all_gather(const void* own, std::size_t bytes) const override {
    std::vector<std::byte> all(bytes * static_cast<std::size_t>(size_));
    check(MPI_Allgather(own, static_cast<int>(bytes), MPI_BYTE, all.data(), static_cast<int>(bytes), MPI_BYTE, all_),
          "MPI_Allgather");
    return all;
  }
  std::vector<std::vector<std::byte>> gather(const void* own, std::size_t bytes) const override {
    const auto size = static_cast<std::int64_t>(bytes);
    const std::vector<std::byte> sizes = all_gather(&size, sizeof size);
    std::vector<std::vector<std::byte>> all;
    std::vector<Message> sent, received;
    if (rank_ == 0) {
      all.resize(static_cast<std::size_t>(size_));
      for (int r = 0; r < size_; ++r) {
        std::int64_t n = 0;
        std::memcpy(&n, sizes.data() + static_cast<std::size_t>(r) * sizeof n, sizeof n);
        auto& part = all[static_cast<std::size_t>(r)];
        part.resize(static_cast<std::size_t>(n));
        if (r == 0 && n > 0) std::memcpy(part.data(), own, bytes);
        if (r != 0) received.push_back({r, part.data(), part.size()});
      }
    } else {
      sent.push_back({0, const_cast<void*>(own), bytes});
    }
    exchange(sent, received);
    return all;
  }
  std::vector<std::int64_t> exchange_counts(const std::vector<std::int64_t>& counts) const override {
    const Stopwatch watch(traffic_.exchanging);
    std::vector<std::int64_t> theirs(counts.size());
    check(MPI_Alltoall(counts.data(), 1, MPI_INT64_T, theirs.data(), 1, MPI_INT64_T, all_), "MPI_Alltoall");
    return theirs;
  }
  void begin_exchange(const std::vector<Message>& sent, const std::vector<Message>& received) const override {
    const Stopwatch watch(traffic_.exchanging);
    const auto post = [&](const Message& m, bool sends) {
      for (std::size_t done = 0; done < m.bytes; done += most_bytes) {
        auto* const at = static_cast<std::byte*>(m.data) + done;
        const int n = static_cast<int>(std::min(most_bytes, m.bytes - done));
        MPI_Request& request = under_way_.emplace_back();
        check(sends ? MPI_Isend(at, n, MPI_BYTE, m.rank, tag, all_, &request)
                    : MPI_Irecv(at, n, MPI_BYTE, m.rank, tag, all_, &request),
              sends ? "MPI_Isend" : "MPI_Irecv");
      }
    };
    for (const Message& m : received) post(m, false);
    for (const Message& m : sent) post(m, true);
    traffic_.messages += static_cast<std::int64_t>(sent.size());
    for (const Message& m : sent) traffic_.bytes += static_cast<std::int64_t>(m.bytes);
  }
  void finish_exchange() const override {
    const Stopwatch watch(traffic_.exchanging);
    check(MPI_Waitall(static_cast<int>(under_way_.size()), under_way_.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    under_way_.clear();
  }
  Traffic& traffic() const override { return traffic_; }
  [[noreturn]] void abort(int exit_code) const override {
    MPI_Abort(all_, exit_code);
    std::abort();
  }

 private:
  /// The type of an element of so many words.
  MPI_Datatype words_of(std::size_t words) const {
    MPI_Datatype& type = types_[words];
    if (type == MPI_DATATYPE_NULL) {
      check(MPI_Type_contiguous(static_cast<int>(words), MPI_INT64_T, &type), "MPI_Type_contiguous");
      check(MPI_Type_commit(&type), "MPI_Type_commit");
    }
    return type;
  }
  struct Type {
    MPI_Datatype type = MPI_DATATYPE_NULL;
    operator MPI_Datatype&() { return type; }
  };

  mutable std::vector<MPI_Request> under_way_;
  mutable std::map<std::size_t, Type> types_;
  mutable Traffic traffic_;
  MPI_Comm all_ = MPI_COMM_NULL;
  MPI_Op both_ = MPI_OP_NULL;
  int rank_ = 0, size_ = 1;
  bool ends_ = false;
};

}  // namespace

std::unique_ptr<Communicator> join_ranks() {
  int begun = 0, size = 1;
  MPI_Initialized(&begun);
  if (begun) MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (std::max(size, started_ranks()) < 2) return nullptr;
  return std::make_unique<MpiCommunicator>();
}

std::string transport_description() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string whole(text, static_cast<std::size_t>(length));
  return whole.substr(0, whole.find_first_of(",\n"));
}

#else

std::unique_ptr<Communicator> join_ranks() {
  if (const int ranks = started_ranks(); ranks > 1)
    throw RanksError(
        fmt::format("{} ranks were started, but this build has no MPI: install libopenmpi-dev and build again", ranks));
  return nullptr;
}

std::string transport_description() { return "none"; }

#endif

}  // namespace drench
