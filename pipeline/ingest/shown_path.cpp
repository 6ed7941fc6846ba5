#include "pipeline/ingest/shown_path.h"

#include <algorithm>
#include <array>
#include <vector>

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLeastWord = 3;    // shorter ones are everywhere
constexpr std::size_t kLeastWithin = 4;  // "johndoe" holds "john"; three letters occur by chance
constexpr std::size_t kLongNumber = 5;   // a date, an ID; an image number has fewer digits

/// Words that say what a file is; descriptions of series are full of them.
constexpr std::array kTrade = {"dicom",  "dcm",   "image",   "images",  "series",  "slice",
                               "slices", "phase", "phases",  "cine",    "exam",    "study",
                               "mri",    "heart", "cardiac", "phantom", "beatlas", "anonymous"};

bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool digit(char c) { return c >= '0' && c <= '9'; }
bool alphanumeric(char c) { return letter(c) || digit(c); }

bool of_the_trade(const std::string& word) {
  return std::find(kTrade.begin(), kTrade.end(), word) != kTrade.end();
}

/// The longest runs of characters that `wanted` accepts, in lower case.
template <class Wanted>
std::vector<std::string> runs(std::string_view text, Wanted wanted) {
  std::vector<std::string> out;
  bool within = false;
  for (const char c : text) {
    if (!wanted(c)) {
      within = false;
      continue;
    }
    if (!within) out.emplace_back();
    within = true;
    out.back() += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return out;
}

std::string without_zeros(const std::string& digits) {
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

/// ".dcm" of "a.dcm"; nothing if what follows the dot may be more than a file format.
std::string standard_extension(const std::string& name) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  constexpr std::array<std::string_view, 22> kEnds{
      ".nii.gz", ".tar.gz", ".dcm", ".dicom", ".ima",  ".img",  ".hdr", ".nii",
      ".nrrd",   ".nhdr",   ".mha", ".mhd",   ".raw",  ".zraw", ".gz",  ".zip",
      ".tar",    ".tgz",    ".7z",  ".txt",   ".json", ".csv"};
  for (const std::string_view end : kEnds) {
    if (lower.size() > end.size() && lower.ends_with(end)) return std::string(end);
  }
  return {};
}

/// "[file 12 of 25 by name]"
std::string by_number(const fs::path& path) {
  std::error_code error;
  const std::string name = path.filename().string();
  const bool folder = fs::is_directory(path, error);
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  auto it = fs::directory_iterator(parent, error);
  std::size_t count = 0;
  std::size_t before = 0;
  bool met = false;
  for (; !error && it != fs::directory_iterator(); it.increment(error)) {
    std::error_code ignored;
    if (it->is_directory(ignored) != folder) continue;
    const std::string other = it->path().filename().string();
    ++count;
    if (other < name) ++before;
    if (other == name) met = true;
  }
  const std::string extension = folder ? std::string() : standard_extension(name);
  if (error || !met) return "[name not shown]" + extension;
  return std::string(folder ? "[folder " : "[file ") + std::to_string(before + 1) + " of " +
         std::to_string(count) + " by name]" + extension;
}

}  // namespace

void IdentityWords::add_text(std::string_view text) {
  for (const std::string& word : runs(text, alphanumeric)) {
    if (word.size() >= kLeastWord) words_.insert(word);
    if (std::any_of(word.begin(), word.end(), letter) && word.size() >= kLeastWithin) {
      letters_.insert(word);
    }
    for (const std::string& part : runs(word, letter)) {
      if (part.size() >= kLeastWord) words_.insert(part);
    }
    for (const std::string& part : runs(word, digit)) {
      const std::string number = without_zeros(part);
      if (number.size() >= kLeastWord) numbers_.insert(number);
    }
  }
}

void IdentityWords::add_uid(std::string_view uid) {
  for (const std::string& word : runs(uid, alphanumeric)) {
    if (word.size() >= kLeastWord) words_.insert(word);
  }
}

void IdentityWords::merge(const IdentityWords& other) {
  words_.insert(other.words_.begin(), other.words_.end());
  letters_.insert(other.letters_.begin(), other.letters_.end());
  numbers_.insert(other.numbers_.begin(), other.numbers_.end());
}

bool IdentityWords::identify(std::string_view name) const {
  const auto odd = [](char c) { return c == '^' || static_cast<unsigned char>(c) >= 0x80; };
  if (std::any_of(name.begin(), name.end(), odd)) return true;
  for (const std::string& number : runs(name, digit)) {
    const std::string value = without_zeros(number);
    if (value.size() >= kLongNumber || numbers_.count(value) > 0) return true;
  }
  const auto known = [this](const std::string& word) {
    return word.size() >= kLeastWord && words_.count(word) > 0 && !of_the_trade(word);
  };
  for (const std::string& word : runs(name, alphanumeric)) {
    if (known(word)) return true;
    for (const std::string& part : runs(word, letter)) {
      if (known(part)) return true;
    }
    const auto holds = [&](const std::string& text) {
      return word.find(text) != std::string::npos && !of_the_trade(text);
    };
    if (std::any_of(letters_.begin(), letters_.end(), holds)) return true;
  }
  return false;
}

std::string shown_path(const fs::path& path, const IdentityWords& words) {
  std::string out;
  fs::path so_far;
  for (const fs::path& part : path) {
    so_far /= part;
    const std::string name = part.string();
    if (name.empty() || name == "/") {  // the root, or a slash at the end
      out += "/";
      continue;
    }
    if (!out.empty() && out.back() != '/') out += '/';
    const bool plain = name == "." || name == ".." || !words.identify(name);
    out += plain ? name : by_number(so_far);
  }
  return out;
}

}  // namespace beatlas::ingest
