#pragma once
/// Strict reading of a JSON object into an options struct: each key is asked for once, a wrong
/// type or range and a key that nobody asked for are Errors that name the JSON path.

#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/base/error.h"

namespace beatlas {

class JsonObject {
 public:
  static constexpr std::size_t kMostNumbers = 1000;

  /// @param path JSON path of `object`, used in messages, e.g. "/segment".
  /// @throws Error{InvalidInput} if `object` is no JSON object.
  JsonObject(const nlohmann::json& object, std::string path);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] const std::string& path() const { return path_; }

  /// The member, which must be there. Marks it as known.
  [[nodiscard]] const nlohmann::json& at(const std::string& key);

  /// Sets `value` from an optional member within [low, high]; leaves it alone if absent.
  void read(const std::string& key, double& value, double low, double high);
  void read(const std::string& key, int& value, int low, int high);
  void read(const std::string& key, bool& value);
  /// Lists of such numbers, of any length up to kMostNumbers.
  void read(const std::string& key, std::vector<double>& values, double low, double high);
  void read(const std::string& key, std::vector<int>& values, int low, int high);
  void read(const std::string& key, std::string& value);

  /// @throws Error{InvalidInput} naming the first key that was never asked for, and the nearest of
  /// those that were.
  void finish() const;

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;
  const nlohmann::json* find(const std::string& key);
  template <class T>
  void read_list(const std::string& key, std::vector<T>& values, T low, T high);

  const nlohmann::json& object_;
  std::string path_;
  std::set<std::string> known_;
  mutable std::set<std::string> names_;  ///< asked for by has() alone, or known; for messages
};

}  // namespace beatlas
