// What goes where: data on stdout, everything else on stderr, colour only where it is wanted.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace salvo::cli {

/// A terminal that lines can be redrawn on.
bool stderr_is_terminal();
/// Columns of the terminal on stderr.
std::size_t terminal_columns();

/// Data. Throws Failure (input_output) when stdout cannot take it, as on a full disk.
void print(std::string_view text);
/// Writes stdout out; the same Failure.
void flush_output();

/// On stderr, a line each.
void say(std::string_view text);
void say_error(std::string_view problem, std::string_view hint = {});
void say_warning(std::string_view problem);

}  // namespace salvo::cli
