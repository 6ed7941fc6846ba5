# Writes a C++ file that tells the SHA-256 of the sources that the program is made of, names and contents:
# cmake -D OUT=sources_hash.cpp -D ROOT=the_project -P sources_hash.cmake
file(GLOB_RECURSE files RELATIVE "${ROOT}" "${ROOT}/pipeline/*" "${ROOT}/runtime/*")
list(SORT files)
set(all "")
foreach(file IN LISTS files)
  if(file MATCHES "\\.(h|cpp)$")
    file(SHA256 "${ROOT}/${file}" hash)
    string(APPEND all "${hash} ${file}\n")
  endif()
endforeach()
string(SHA256 hash "${all}")
file(WRITE "${OUT}" "#include \"pipeline/build/version.h\"\n
namespace beatlas::build {\n
const char* sources_sha256() noexcept { return \"${hash}\"; }\n
}  // namespace beatlas::build\n")
