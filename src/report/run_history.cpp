#include "report/run_history.hpp"

#include <algorithm>
#include <fstream>
#include <regex>

namespace drench {
namespace {

constexpr std::size_t stamp_length = 19, text_begins = 21;  // RunLog::write

void add_once(std::vector<std::string>& list, const std::string& text) {
  if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(text);
}

/// The part of `text` after `begin`, if it begins so.
bool after(const std::string& text, const std::string& begin, std::string& rest) {
  if (!text.starts_with(begin)) return false;
  rest = text.substr(begin.size());
  return true;
}

/// "CAUSE; REMEDY; see FILE; the last checkpoint is FILE", once the remedy is known.
void split_failure(RunFailureText& failure) {
  const std::size_t at = failure.remedy.empty() ? std::string::npos : failure.cause.find("; " + failure.remedy);
  if (at == std::string::npos) return;
  const std::size_t rest = at + 2 + failure.remedy.size() + 2;
  failure.files = rest < failure.cause.size() ? failure.cause.substr(rest) : "";
  failure.cause.resize(at);
}

class Reader {
 public:
  void line(const std::string& stamp, const std::string& text) {
    if (text.starts_with("drench ") && text.find(" precision), backend ") != std::string::npos) begin();
    if (history_.begun.empty()) history_.begun = stamp;
    history_.ended = stamp;
    std::string rest;
    if (after(text, "scene ", history_.scene) || ended_well(text) || failed(text)) return;
    if (after(text, "warning: ", rest)) return add_once(history_.warnings, rest);
    if (after(text, "remedy: ", rest)) history_.failure.remedy = rest;
    if (after(text, "peak memory of the backend's arrays ", rest)) history_.memory = rest.substr(0, rest.find(','));
    if (!is_total(text)) return;
    add_once(history_.totals, text);
    static const std::regex solve(R"(the (\w+) solve did not converge in (\d+) of .*)");
    if (std::smatch match; std::regex_match(text, match, solve))
      history_.not_converged[match[1]] = std::stoll(match[2]);
  }
  RunHistory take() {
    split_failure(history_.failure);
    return std::move(history_);
  }

 private:
  void begin() {
    ++history_.sessions;
    history_.ending = Ending::unfinished;
    history_.failure = {};
    history_.totals.clear();
    history_.not_converged.clear();
  }
  bool ended_well(const std::string& text) {
    static const std::regex done(R"(\d+ steps to t = .* s in .* s, mass error .* kg)");
    if (text.starts_with("interrupted at step ")) history_.ending = Ending::interrupted;
    if (std::regex_match(text, done) && history_.ending == Ending::unfinished) history_.ending = Ending::done;
    return history_.ending == Ending::done && std::regex_match(text, done);
  }
  bool failed(const std::string& text) {
    static const std::regex failure(R"(drench: the run failed in stage (\w+) at step (\d+) \(t = ([^ ]+) s\): (.*))");
    static const std::regex stop(R"(stopped at step (\d+): (.*))");
    std::smatch match;
    if (std::regex_match(text, match, failure)) {
      history_.ending = Ending::failed;
      history_.failure = {match[1], std::stoll(match[2]), match[3], match[4], "", ""};
      return true;
    }
    if (!std::regex_match(text, match, stop)) return false;
    history_.ending = Ending::stopped;
    history_.failure = {"", std::stoll(match[1]), "", match[2], "", ""};
    return true;
  }
  /// The lines of RunTotals::warnings().
  static bool is_total(const std::string& text) {
    static const std::regex total(
        R"((the .* solve did not converge in \d+ of|particles passed through|cloth was stretched to|)"
        R"(particles were |\d+ particles left the domain).*)");
    return std::regex_match(text, total);
  }

  RunHistory history_;
};

}  // namespace

RunHistory read_history(const std::filesystem::path& log) {
  std::ifstream in(log, std::ios::binary);
  Reader reader;
  for (std::string line; std::getline(in, line);)
    if (line.size() > text_begins) reader.line(line.substr(0, stamp_length), line.substr(text_begins));
  return reader.take();
}

}  // namespace drench
