#include "runtime/haptics/recorder.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>
#include <string_view>
#include <type_traits>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

static_assert(std::is_trivially_copyable_v<TickRecord>);

// The one list of what a line holds: visit(name, value) for every number, in order.
template <class Record, class Visit>
void each_number(Record& r, Visit visit) {
  const auto list = [&](const std::string& name, auto& values) {
    for (std::size_t n = 0; n < values.size(); ++n) visit(name + std::to_string(n), values[n]);
  };
  visit("t_s", r.time_s);
  list("x_mm_", r.position_mm);
  list("q_", r.orientation);
  visit("valid", r.valid);
  visit("stopped", r.stopped);
  visit("restarted", r.restarted);
  visit("scene", r.scene);
  visit("rate_hz", r.wish.rate_hz);
  visit("paused", r.wish.paused);
  visit("hold_phase", r.wish.hold_phase);
  list("model_", r.before.model);
  list("heart_", r.before.heart);
  list("safety_", r.before.safety);
  visit("last_t_s", r.before.last_time_s);
  visit("ran", r.before.ran);
  visit("status", r.status);
  list("f_n_", r.force_n);
  list("model_f_n_", r.model_force_n);
  visit("distance_mm", r.distance_mm);
}

// The line that names the columns.
std::string column_names() {
  std::string out;
  TickRecord columns;
  each_number(columns,
              [&](const std::string& name, auto&) { out += out.empty() ? name : ',' + name; });
  return out;
}

void append(std::string& line, double value) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  line.append(digits.data(), error == std::errc() ? end : digits.data());
}

template <class T>
void set(T& value, double number) {
  if constexpr (std::is_same_v<T, double>) {
    value = number;
  } else if constexpr (std::is_same_v<T, bool>) {
    value = number != 0;
  } else {
    value = static_cast<T>(static_cast<std::uint32_t>(number));
  }
}

// Largest value that is no double; a double may be anything, even no number.
template <class T>
double largest() {
  if constexpr (std::is_same_v<T, bool>) return 1;
  return std::is_same_v<T, TickStatus> ? 2 : 4294967295.0;
}

bool next_line(std::istream& in, std::string& line) {
  if (!std::getline(in, line)) return false;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return true;
}

// @param where the file's name and the line's number, for messages
void read_tick(const std::string& line, const std::string& where, TickRecord& tick) {
  const char* at = line.data();
  const char* const end = line.data() + line.size();
  bool first = true;
  each_number(tick, [&](const std::string& column, auto& value) {
    const auto fail = [&] {
      throw_invalid(where + ", column " + column + ": must be a number of its range");
    };
    if (!first && (at == end || *at++ != ',')) fail();
    first = false;
    double read = 0;
    const auto [next, error] = std::from_chars(at, end, read);
    if (error != std::errc()) fail();
    at = next;
    using T = std::remove_reference_t<decltype(value)>;
    if constexpr (!std::is_same_v<T, double>) {
      if (!(read >= 0 && read <= largest<T>() && read == std::floor(read))) fail();
    }
    set(value, read);
  });
  if (at != end) throw_invalid(where + ": there are too many columns");
}

}  // namespace

Recorder::Recorder(std::size_t ticks, std::size_t after_fault)
    : after_fault_(std::min(after_fault, ticks / 2)) {
  if (ticks > kMostTicks) throw_invalid("at most 1048576 ticks of a servo can be recorded");
  ring_.resize(ticks);
}

void Recorder::record(const TickRecord& record) noexcept {
  if (ring_.empty() || frozen_.load(std::memory_order_acquire)) return;
  ring_[written_ % ring_.size()] = record;
  ++written_;
  if (!faulted_ && record.status == TickStatus::Fault) {
    faulted_ = true;
    left_ = after_fault_ + 1;
  }
  const bool full = faulted_ && --left_ == 0;
  if (full || asked_.load(std::memory_order_acquire)) {
    frozen_.store(true, std::memory_order_release);
  }
}

std::vector<TickRecord> Recorder::ticks() const {
  const std::size_t count = std::min(written_, ring_.size());
  std::vector<TickRecord> out;
  out.reserve(count);
  for (std::size_t n = written_ - count; n < written_; ++n) out.push_back(ring_[n % ring_.size()]);
  return out;
}

void Recorder::resume() noexcept {
  written_ = 0;
  faulted_ = false;
  asked_.store(false, std::memory_order_release);
  frozen_.store(false, std::memory_order_release);
}

void write_ticks(std::ostream& out, const std::string& about,
                 const std::vector<TickRecord>& ticks) {
  out << kTicksFormat << '\n' << about << '\n' << column_names() << '\n';
  for (const TickRecord& tick : ticks) {
    std::string line;
    each_number(tick, [&](const std::string&, const auto& value) {
      if (!line.empty()) line += ',';
      append(line, static_cast<double>(value));
    });
    out << line << '\n';
  }
}

RecordedTicks read_ticks(std::istream& in, const std::string& name) {
  RecordedTicks out;
  std::string line;
  if (!next_line(in, line) || line != kTicksFormat) {
    throw_invalid(name + " is no recording of ticks; its first line must be \"" +
                  std::string(kTicksFormat) + "\"");
  }
  std::string header;
  if (!next_line(in, out.about) || !next_line(in, header)) {
    throw_invalid(name + " ends before its line 3, which names the columns");
  }
  if (header != column_names()) {
    throw_invalid(name + ", line 3: the columns are not those of this version; record again");
  }
  for (int number = 4; next_line(in, line); ++number) {
    read_tick(line, name + ", line " + std::to_string(number), out.ticks.emplace_back());
  }
  if (in.bad()) throw Error(ErrorCode::Machine, name + " cannot be read to its end");
  return out;
}

}  // namespace beatlas::haptics
