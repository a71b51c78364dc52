#pragma once
// The processes ("ranks") of one run and what they tell each other. Which particles travel is the backend's affair
// (backends/kokkos/particles/exchange.hpp). Design: docs/dev/distribution.md.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace drench {

/// Bytes for or from one rank.
struct Message {
  int rank = 0;
  void* data = nullptr;
  std::size_t bytes = 0;
};

/// What a rank has told the others so far, and the wall time that it took, waiting for them included.
struct Traffic {
  double summing = 0, exchanging = 0, packing = 0;  // s
  std::int64_t sums = 0, messages = 0, bytes = 0;   // calls; sent
  bool fenced = false;                              // profiling: `packing` has no kernels before it
};

/// All ranks of a run. Every call but rank(), size() and abort() is made by all of them, in the same order.
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual std::string description() const = 0;  ///< the library, in a line
  /// Each number becomes the sum, or the largest, of all ranks' numbers.
  virtual void all_reduce(std::span<std::int64_t> sums, std::span<double> maxima) const = 0;
  /// Each bit becomes 1 where it is 1 on any rank.
  virtual void all_or(void* data, std::size_t bytes) const = 0;
  /// `own` bytes of every rank, as many of each, in the order of ranks.
  virtual std::vector<std::byte> all_gather(const void* own, std::size_t bytes) const = 0;
  /// The bytes of every rank at rank 0, which may be of different numbers; empty elsewhere.
  virtual std::vector<std::vector<std::byte>> gather(const void* own, std::size_t bytes) const = 0;
  /// A number for each rank against one from each rank.
  virtual std::vector<std::int64_t> exchange_counts(const std::vector<std::int64_t>& counts) const = 0;
  /// Sends and receives; both sides agree on ranks and sizes.
  void exchange(const std::vector<Message>& sent, const std::vector<Message>& received) const {
    begin_exchange(sent, received);
    finish_exchange();
  }
  /// The same in two parts. Until the second the bytes are on their way, and no other exchange begins.
  virtual void begin_exchange(const std::vector<Message>& sent, const std::vector<Message>& received) const = 0;
  virtual void finish_exchange() const = 0;
  /// To read, and for whoever packs.
  virtual Traffic& traffic() const = 0;
  /// Ends every rank.
  [[noreturn]] virtual void abort(int exit_code) const = 0;
};

/// Ranks that cannot run together. One line.
struct RanksError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Whether all ranks have the same texts, which are named for the error: "scene", what it says.
/// @throws RanksError on all ranks, with the first rank and the first name that differ from rank 0's
void require_agreement(const Communicator& ranks, const std::vector<std::pair<std::string, std::string>>& texts);

/// How many ranks started this program together, by the environment that mpirun and srun give; 1 if none did.
int started_ranks();
/// This rank's number among those of its host, by the same environment; 0 if there is none.
int local_rank();
/// Joins the ranks that were started together, or all of MPI_COMM_WORLD where the program has initialised MPI; null for
/// one alone. Where it initialises MPI itself, it ends it with the object.
/// @throws RanksError where this build knows no MPI
std::unique_ptr<Communicator> join_ranks();
/// What join_ranks() would talk through: "Open MPI v4.1.4", or "none".
std::string transport_description();

}  // namespace drench
