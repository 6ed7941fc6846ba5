#include "runtime/base/json_object.h"

#include <sstream>
#include <utility>

#include "runtime/base/nearest_name.h"

namespace beatlas {
namespace {

constexpr std::size_t kMostNamesTold = 16;

}  // namespace

JsonObject::JsonObject(const nlohmann::json& object, std::string path)
    : object_(object), path_(std::move(path)) {
  if (!object_.is_object()) {
    throw_invalid((path_.empty() ? "/" : path_) + " must be a JSON object");
  }
}

void JsonObject::fail(const std::string& key, const std::string& what) const {
  throw_invalid(path_ + "/" + key + " " + what);
}

bool JsonObject::has(const std::string& key) const {
  names_.insert(key);
  return object_.contains(key);
}

const nlohmann::json* JsonObject::find(const std::string& key) {
  known_.insert(key);
  names_.insert(key);
  const auto it = object_.find(key);
  return it == object_.end() ? nullptr : &*it;
}

const nlohmann::json& JsonObject::at(const std::string& key) {
  const nlohmann::json* member = find(key);
  if (member == nullptr) fail(key, "is missing");
  return *member;
}

void JsonObject::read(const std::string& key, double& value, double low, double high) {
  const nlohmann::json* member = find(key);
  if (member == nullptr) return;
  const double number = member->is_number() ? member->get<double>() : low - 1;
  if (!member->is_number() || !(number >= low && number <= high)) {
    std::ostringstream range;
    range << "must be a number from " << low << " to " << high;
    fail(key, range.str());
  }
  value = number;
}

void JsonObject::read(const std::string& key, int& value, int low, int high) {
  const nlohmann::json* member = find(key);
  if (member == nullptr) return;
  if (!member->is_number_integer() || member->get<double>() < low || member->get<double>() > high) {
    fail(key, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  }
  value = member->get<int>();
}

template <class T>
void JsonObject::read_list(const std::string& key, std::vector<T>& values, T low, T high) {
  const nlohmann::json* member = find(key);
  if (member == nullptr) return;
  if (!member->is_array() || member->size() > kMostNumbers) {
    fail(key, "must be a list of up to " + std::to_string(kMostNumbers) + " numbers");
  }
  std::vector<T> out;
  for (std::size_t at = 0; at < member->size(); ++at) {
    const nlohmann::json entry{{std::to_string(at), (*member)[at]}};
    T value{};
    JsonObject(entry, path_ + "/" + key).read(std::to_string(at), value, low, high);
    out.push_back(value);
  }
  values = std::move(out);
}

void JsonObject::read(const std::string& key, std::vector<double>& values, double low,
                      double high) {
  read_list(key, values, low, high);
}

void JsonObject::read(const std::string& key, std::vector<int>& values, int low, int high) {
  read_list(key, values, low, high);
}

void JsonObject::read(const std::string& key, bool& value) {
  const nlohmann::json* member = find(key);
  if (member == nullptr) return;
  if (!member->is_boolean()) fail(key, "must be true or false");
  value = member->get<bool>();
}

void JsonObject::read(const std::string& key, std::string& value) {
  const nlohmann::json* member = find(key);
  if (member == nullptr) return;
  if (!member->is_string()) fail(key, "must be a string");
  value = member->get<std::string>();
}

void JsonObject::finish() const {
  for (const auto& item : object_.items()) {
    if (known_.count(item.key()) != 0) continue;
    const std::string meant = nearest_name(item.key(), names_);
    std::string all;
    if (meant.empty() && names_.size() <= kMostNamesTold) {
      for (const std::string& name : names_) all += (all.empty() ? "; known are " : ", ") + name;
    }
    fail(item.key(),
         "is not a known key" + (meant.empty() ? all : "; did you mean " + meant + "?"));
  }
}

}  // namespace beatlas
