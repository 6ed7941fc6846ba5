#pragma once
/// Structs of numbers as JSON objects, by one table a struct: a number's key, its member, its
/// range.

#include <array>
#include <string>

#include "runtime/base/json_object.h"

namespace beatlas {

template <class T>
struct JsonNumber {
  const char* key;
  double T::*member;
  double low;
  double high;
};

/// Sets the members whose keys are there. @throws Error{InvalidInput} as JsonObject::read
template <class T, std::size_t N>
void read_numbers(JsonObject& object, T& value, const std::array<JsonNumber<T>, N>& numbers) {
  for (const JsonNumber<T>& number : numbers) {
    object.read(number.key, value.*number.member, number.low, number.high);
  }
}

/// The same of an optional member `key` of `parent`, which must hold nothing else.
template <class T, std::size_t N>
void read_section(JsonObject& parent, const std::string& key, T& value,
                  const std::array<JsonNumber<T>, N>& numbers) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  read_numbers(object, value, numbers);
  object.finish();
}

template <class T, std::size_t N>
[[nodiscard]] nlohmann::json numbers_to_json(const T& value,
                                             const std::array<JsonNumber<T>, N>& numbers) {
  nlohmann::json out = nlohmann::json::object();
  for (const JsonNumber<T>& number : numbers) out[number.key] = value.*number.member;
  return out;
}

}  // namespace beatlas
