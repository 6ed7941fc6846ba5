#pragma once
/// The family of random hearts: what differs between people and between scanners, drawn from one
/// table of ranges (family.json, each with its unit and source).

#include <cstdint>
#include <numbers>
#include <string_view>

namespace beatlas::phantom {

inline constexpr float kPi = std::numbers::pi_v<float>;

/// What a heart is drawn for. Hearts of one purpose are never those of another, whatever the seed,
/// so that a network is not judged on what it learned from.
enum class Purpose : std::uint32_t { Training, Judging };

/// How far a draw goes: through every range whole; or, where a row says what is usual, as exams of
/// a clinic mostly are, which may lie beyond the range that others are drawn from.
enum class Ranges : std::uint8_t { Whole, Usual };

/// The numbers of one draw. Each is a function of the seed, its name and its index alone, so that a
/// number added to the table changes no other.
class Family {
 public:
  Family(std::uint32_t seed, Purpose purpose, Ranges ranges = Ranges::Whole) noexcept
      : seed_(seed), purpose_(purpose), ranges_(ranges) {}

  [[nodiscard]] std::uint32_t seed() const noexcept { return seed_; }
  [[nodiscard]] Purpose purpose() const noexcept { return purpose_; }
  [[nodiscard]] Ranges ranges() const noexcept { return ranges_; }
  /// A number of the table within its range, by its law: uniform or, where a quantity spans
  /// factors, uniform in its logarithm. @throws std::logic_error if family.json has no such row
  [[nodiscard]] float number(std::string_view name, std::uint32_t index = 0) const;
  /// Whether something happens that the table gives a chance.
  [[nodiscard]] bool happens(std::string_view name, std::uint32_t index = 0) const;
  /// Whether a value lies in the range of a row. @throws as number
  [[nodiscard]] static bool in_range(std::string_view name, float value);
  /// Uniform in (0, 1), and standard normal, for choices that have no range of their own.
  [[nodiscard]] float uniform(std::string_view name, std::uint32_t index = 0) const;
  [[nodiscard]] float normal(std::string_view name, std::uint32_t index = 0) const;
  /// Uniform in (low, high).
  [[nodiscard]] float between(float low, float high, std::string_view name,
                              std::uint32_t index = 0) const {
    return low + (high - low) * uniform(name, index);
  }

 private:
  [[nodiscard]] std::uint32_t bits(std::string_view name, std::uint32_t index, int which) const;

  std::uint32_t seed_;
  Purpose purpose_;
  Ranges ranges_;
};

}  // namespace beatlas::phantom
