#include "pipeline/ingest/shown_path.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <vector>

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLeastWord = 3;    // shorter ones are everywhere
constexpr std::size_t kLeastWithin = 4;  // "johndoe" holds "john"; three letters occur by chance
constexpr std::size_t kLongNumber = 5;   // a date, an ID; an image number has fewer digits
constexpr std::size_t kLeastJoined = 4;  // characters of words that are written as one elsewhere
constexpr std::size_t kMostJoined = 64;
constexpr std::size_t kLeastShort = 2;  // an ID such as 42, a name such as Li

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

/// A control character would break the line of a message, or command the terminal.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }, '?');
  return text;
}

std::string without_zeros(const std::string& digits) {
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

/// Neighbouring runs written as one, two and more at a time.
template <class Found>
bool any_joined(const std::vector<std::string>& parts, Found found) {
  for (std::size_t first = 0; first + 1 < parts.size(); ++first) {
    std::string joined = parts[first];
    for (std::size_t last = first + 1; last < parts.size(); ++last) {
      joined += parts[last];
      if (joined.size() > kMostJoined) break;
      if (joined.size() >= kLeastJoined && found(joined)) return true;
    }
  }
  return false;
}

bool all_digits(const std::string& word) { return std::all_of(word.begin(), word.end(), digit); }

/// Whether the text holds a date that is written apart: 1980-01-02, 02.01.1980.
bool holds_parted_date(std::string_view text) {
  for (std::size_t at = 0; at + 10 <= text.size(); ++at) {
    const auto fits = [&](std::string_view form) {
      if (at > 0 && digit(text[at - 1])) return false;
      if (at + 10 < text.size() && digit(text[at + 10])) return false;
      for (std::size_t i = 0; i < form.size(); ++i) {
        if (form[i] == '0' ? !digit(text[at + i]) : alphanumeric(text[at + i])) return false;
      }
      return true;
    };
    if (fits("0000-00-00") || fits("00-00-0000")) return true;
  }
  return false;
}

/// Other ways to write a date of the form YYYYMMDD, in digits alone.
std::vector<std::string> forms_of_date(const std::string& digits) {
  if (digits.size() != 8) return {};
  const std::string century = digits.substr(0, 2);
  if (century < "18" || century > "21") return {};
  const std::string year = digits.substr(2, 2);
  const std::string month = digits.substr(4, 2);
  const std::string day = digits.substr(6, 2);
  if (month < "01" || month > "12" || day < "01" || day > "31") return {};
  return {digits,
          day + month + century + year,
          month + day + century + year,
          year + month + day,
          day + month + year,
          month + day + year};
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
    for (const std::string& form : forms_of_date(word)) numbers_.insert(without_zeros(form));
  }
  add_joined(runs(text, alphanumeric));
  for (std::size_t at = 0; at < text.size();) {  // of a name, each of its parts
    const std::size_t end = std::min(text.find_first_of("^=\\", at), text.size());
    add_joined(runs(text.substr(at, end - at), alphanumeric));
    at = end + 1;
  }
}

void IdentityWords::add_joined(const std::vector<std::string>& parts) {
  std::string joined;
  bool plain = true;  // of words of the trade and short numbers alone: "series 4"
  for (const std::string& part : parts) {
    joined += part;
    plain = plain && (of_the_trade(part) || (all_digits(part) && part.size() < kLeastWord));
  }
  const bool number = all_digits(joined);
  if (joined.size() < kLeastJoined || joined.size() > kMostJoined || (plain && !number)) return;
  words_.insert(joined);
  // Of 0001 no number is left that would not be everywhere.
  const std::string value = number ? without_zeros(joined) : std::string();
  if (value.size() >= kLeastWord) numbers_.insert(value);
}

void IdentityWords::add_identity(std::string_view text) {
  add_text(text);
  const std::vector<std::string> parts = runs(text, alphanumeric);
  for (const std::string& part : parts) {
    if (part.size() >= kLeastShort) short_.insert(part);
    const std::string number = all_digits(part) ? without_zeros(part) : std::string();
    if (number.size() >= kLeastShort) short_.insert(number);
  }
  add_joined({parts.rbegin(), parts.rend()});  // "Li Wu" of "Wu^Li"
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
  short_.insert(other.short_.begin(), other.short_.end());
}

bool IdentityWords::identify(std::string_view name) const {
  const auto odd = [](char c) { return c == '^' || static_cast<unsigned char>(c) >= 0x80; };
  if (std::any_of(name.begin(), name.end(), odd)) return true;
  for (const std::string& number : runs(name, digit)) {
    const std::string value = without_zeros(number);
    if (value.size() >= kLongNumber || numbers_.count(value) > 0) return true;
  }
  if (holds_parted_date(name)) return true;
  const std::vector<std::string> words = runs(name, alphanumeric);
  const auto known_joined = [this](const std::string& joined) {
    return words_.count(joined) > 0 ||
           (all_digits(joined) && numbers_.count(without_zeros(joined)) > 0);
  };
  return any_joined(words, known_joined) ||
         std::any_of(words.begin(), words.end(),
                     [this](const std::string& word) { return identifies(word); });
}

bool IdentityWords::identifies(const std::string& word) const {
  if (short_.count(word) > 0) return true;
  if (all_digits(word) && short_.count(without_zeros(word)) > 0) return true;
  const auto known = [this](const std::string& text) {
    return text.size() >= kLeastWord && words_.count(text) > 0 && !of_the_trade(text);
  };
  if (known(word)) return true;
  const std::vector<std::string> parts = runs(word, letter);
  if (std::any_of(parts.begin(), parts.end(), known)) return true;
  return std::any_of(letters_.begin(), letters_.end(), [&](const std::string& text) {
    return word.find(text) != std::string::npos && !of_the_trade(text);
  });
}

namespace {

/// What lies of `path` behind its first `skipped` parts, as shown_path shows it.
std::string shown_from(const fs::path& path, std::ptrdiff_t skipped, const IdentityWords& words) {
  std::string out;
  fs::path so_far;
  for (const fs::path& part : path) {
    so_far /= part;
    if (skipped-- > 0) continue;
    const std::string name = part.string();
    if (name.empty() || name == "/") {  // the root, or a slash at the end
      out += "/";
      continue;
    }
    if (!out.empty() && out.back() != '/') out += '/';
    const bool plain = name == "." || name == ".." || !words.identify(name);
    out += plain ? printable(name) : by_number(so_far);
  }
  return out;
}

/// Of how many parts of `path` the folder or file `above` consists; nothing if it lies elsewhere.
std::optional<std::ptrdiff_t> parts_above(const fs::path& above, const fs::path& path) {
  const fs::path bare = above.has_filename() ? above : above.parent_path();  // "exam/"
  const auto [rest, differs] = std::mismatch(bare.begin(), bare.end(), path.begin(), path.end());
  if (bare.empty() || rest != bare.end()) return std::nullopt;
  return std::distance(path.begin(), differs);
}

}  // namespace

std::string shown_path(const fs::path& path, const IdentityWords& words) {
  return shown_from(path, 0, words);
}

std::string shown_to(const std::vector<fs::path>& typed, const fs::path& path,
                     const IdentityWords& words) {
  for (const fs::path& each : typed) {
    if (each == path) return printable(path.string());
  }
  for (const fs::path& each : typed) {
    const std::optional<std::ptrdiff_t> above = parts_above(each, path);
    if (!above) continue;
    const std::string start = printable(each.string());
    const std::string rest = shown_from(path, *above, words);
    return start + (start.ends_with('/') || rest.empty() ? "" : "/") + rest;
  }
  return shown_path(path, words);
}

std::string shown_below(const std::vector<fs::path>& typed, const fs::path& path,
                        const IdentityWords& words) {
  for (const fs::path& each : typed) {
    const std::optional<std::ptrdiff_t> above = parts_above(each, path);
    if (!above) continue;
    const std::string rest = shown_from(path, *above, words);
    return rest.empty() ? shown_from(path, *above - 1, words) : rest;
  }
  return shown_path(path, words);
}

}  // namespace beatlas::ingest
