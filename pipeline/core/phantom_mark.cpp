#include "pipeline/core/phantom_mark.h"

#include <algorithm>

namespace beatlas {
namespace {

constexpr std::string_view kPrefix = "phantom:";
constexpr std::size_t kDigits = 64;

}  // namespace

bool is_phantom_identity(std::string_view text) noexcept {
  return text.size() == kDigits && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

std::string phantom_mark(std::string_view identity) {
  return identity.empty() ? std::string() : std::string(kPrefix) + std::string(identity);
}

std::string identity_of_mark(std::string_view text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  if (!text.starts_with(kPrefix)) return {};
  text.remove_prefix(kPrefix.size());
  return is_phantom_identity(text) ? std::string(text) : std::string();
}

}  // namespace beatlas
