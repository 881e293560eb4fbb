#include "solver/contact_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <utility>

#include "soa/contact_fields.hpp"
#include "solver/contact_rows.hpp"

namespace salvo::solver {

namespace {

using soa::ContactField;

constexpr std::size_t index(ContactField field) { return static_cast<std::size_t>(field); }

// Calls visit(slot, lane) for the contacts of a group, slots ascending.
template <class Visit>
void for_contacts(const soa::Array<std::uint64_t>& first_slot,
                  const soa::Array<std::uint16_t>& touching, std::size_t group,
                  const Visit& visit) {
  for (std::size_t slot = first_slot[group]; slot < first_slot[group + 1]; ++slot) {
    for (std::uint32_t left = touching[slot]; left != 0; left &= left - 1) {
      visit(slot, static_cast<std::size_t>(std::countr_zero(left)));
    }
  }
}

}  // namespace

template <class T>
void ContactMemory<T>::share_out() {
  std::size_t entries = 0;
  for (std::size_t row = 0; row < rows_; ++row) {
    Entries& own = entries_[row];
    entries += own.last;
    own.first = own.last = static_cast<std::uint32_t>(entries - own.last);
  }
  if (entries > std::numeric_limits<std::uint32_t>::max()) {
    throw std::length_error(fmt::format("{} contacts are more than can be remembered", entries));
  }
  partner_.resize(entries);
  if (law_.remembers()) tangential_.resize(3 * entries);
  if (law_.rolls()) rolling_.resize(3 * entries);
}

// ---- tables -------------------------------------------------------------------------------------

template <class T>
void ContactMemory<T>::load(const soa::Table& contacts, std::span<const soa::Id> ids,
                            std::size_t rows) {
  // Both sides of every contact, in the order of the ids.
  const std::size_t pairs = contacts.rows();
  const soa::Id* id = contacts.ids();
  const auto* partner = contacts.column<std::uint64_t>(index(ContactField::partner));
  const auto rank_of = [&](soa::Id wanted) {
    const auto at = std::ranges::lower_bound(ids, wanted);
    if (at == ids.end() || *at != wanted) {
      throw std::invalid_argument("a contact is of a particle that is not there");
    }
    return static_cast<std::uint32_t>(at - ids.begin());
  };
  std::vector<std::array<std::uint32_t, 2>> sides(pairs);
  rows_ = rows;
  entries_.resize(rows);
  std::fill_n(entries_.data(), rows, Entries{});
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    const bool wall = soa::stream_of(partner[pair]) == soa::max_stream;
    sides[pair] = {rank_of(id[pair]),
                   wall ? wall_flag | static_cast<std::uint32_t>(soa::serial_of(partner[pair]))
                        : rank_of(partner[pair])};
    // A list in another order would find some of them and forget the others.
    if (pair > 0 && sides[pair] <= sides[pair - 1]) {
      throw std::invalid_argument("contacts are not sorted by id and partner");
    }
    ++entries_[sides[pair][0]].last;
    if (!wall) ++entries_[sides[pair][1]].last;
  }
  share_out();
  const auto add = [&](std::uint32_t row, std::uint32_t other, std::size_t pair, T sign) {
    const std::size_t entry = entries_[row].last++;
    partner_[entry] = other;
    for (std::size_t c = 0; c < 3; ++c) {
      if (law_.remembers()) {
        tangential_[3 * entry + c] =
            sign * contacts.column<T>(index(ContactField::tangential_displacement), c)[pair];
      }
      if (law_.rolls()) {
        rolling_[3 * entry + c] =
            contacts.column<T>(index(ContactField::rolling_displacement), c)[pair];
      }
    }
  };
  // The higher sides first: a row's partners of lower id come before those of higher id.
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    if ((sides[pair][1] & wall_flag) == 0) add(sides[pair][1], sides[pair][0], pair, T(-1));
  }
  for (std::size_t pair = 0; pair < pairs; ++pair) add(sides[pair][0], sides[pair][1], pair, T(1));
  collected_ = true;
}

template <class T>
void ContactMemory<T>::store(std::span<const soa::Id> ids, std::span<const std::uint32_t> row_of,
                             std::span<const std::uint8_t> lives, soa::Table& contacts) const {
  // Calls visit(task, place, entry) where a place speaks for a pair, tasks beside each other.
  const auto for_pairs = [&](const auto& visit) {
    for_rows(parallel_, ids.size(), [&](std::size_t first, std::size_t last) {
      for (std::size_t place = first; place < last; ++place) {
        if (lives[place] == 0) continue;
        const Entries own = entries_[row_of[place]];
        for (std::uint32_t entry = own.first; entry < own.last; ++entry) {
          const std::uint32_t partner = partner_[entry];
          const bool wall = (partner & wall_flag) != 0;
          if (wall || (partner > place && lives[partner] != 0)) {
            visit(first / rows_per_task, place, entry);
          }
        }
      }
    });
  };
  std::vector<std::size_t> next_pair(tasks_of(ids.size(), rows_per_task));
  for_pairs([&](std::size_t task, std::size_t, std::uint32_t) { ++next_pair[task]; });
  std::size_t pairs = 0;
  for (std::size_t& next : next_pair) pairs += std::exchange(next, pairs);
  contacts.append(pairs);

  const auto column = [&](ContactField field, std::size_t c) {
    return contacts.column<T>(index(field), c);
  };
  soa::Id* const id = contacts.ids();
  auto* const partner_id = contacts.column<std::uint64_t>(index(ContactField::partner));
  std::array<T*, 3> tangential{};
  std::array<T*, 3> rolling{};
  for (std::size_t c = 0; c < 3; ++c) {
    tangential[c] = column(ContactField::tangential_displacement, c);
    rolling[c] = column(ContactField::rolling_displacement, c);
  }
  for_pairs([&](std::size_t task, std::size_t place, std::uint32_t entry) {
    const std::size_t pair = next_pair[task]++;
    const std::uint32_t partner = partner_[entry];
    const bool wall = (partner & wall_flag) != 0;
    id[pair] = ids[place];
    partner_id[pair] = wall ? soa::obstacle_partner(partner & ~wall_flag) : ids[partner];
    for (std::size_t c = 0; c < 3; ++c) {
      tangential[c][pair] = tangential_[3 * std::size_t{entry} + c];
      if (rolling[c]) rolling[c][pair] = rolling_[3 * std::size_t{entry} + c];
    }
  });
}

// ---- from lists to rows and back ----------------------------------------------------------------

template <class T>
void ContactMemory<T>::collect(const SlotLists& lists, const WallLists<T>& walls,
                               const soa::Array<std::uint32_t>& rank) {
  if (std::exchange(collected_, true) || !law_.remembers()) return;
  entries_.resize(rows_);
  for_groups(parallel_, rows_, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t group = first; group < last; ++group) {
      Entries* own = entries_.data() + group * group_rows;
      std::fill_n(own, group_rows, Entries{});
      const auto count = [&](std::size_t, std::size_t lane) { ++own[lane].last; };
      for_contacts(lists.first_slot, touching_, group, count);
      for_contacts(walls.first_slot, walls.touching, group, count);
    }
  });
  share_out();
  for_groups(parallel_, rows_, [&](std::size_t task, std::size_t first, std::size_t last) {
    const TaskHistory& history = history_[task];
    std::size_t contact = 0;
    for (std::size_t group = first; group < last; ++group) {
      Entries* own = entries_.data() + group * group_rows;
      for_contacts(lists.first_slot, touching_, group, [&](std::size_t slot, std::size_t lane) {
        const std::size_t entry = own[lane].last++;
        const std::int32_t other = lists.neighbor[slot * group_rows + lane];
        partner_[entry] = rank[static_cast<std::size_t>(other)];
        const T* from = history.numbers.data() + contact;
        for (std::size_t c = 0; c < 3; ++c) {
          tangential_[3 * entry + c] = from[c * history.contacts];
          if (law_.rolls()) rolling_[3 * entry + c] = from[(3 + c) * history.contacts];
        }
        ++contact;
      });
      for_contacts(walls.first_slot, walls.touching, group,
                   [&](std::size_t slot, std::size_t lane) {
                     const std::size_t entry = own[lane].last++;
                     partner_[entry] = wall_flag | walls.part[slot];
                     for (std::size_t c = 0; c < 3; ++c) {
                       const std::size_t from = (slot * 3 + c) * group_rows + lane;
                       tangential_[3 * entry + c] = walls.tangential[from];
                       if (law_.rolls()) rolling_[3 * entry + c] = walls.rolling[from];
                     }
                   });
    }
  });
}

template <class T>
void ContactMemory<T>::move_rows(const soa::Array<std::uint32_t>& source) {
  if (!law_.remembers()) return;
  soa::Array<Entries> moved;
  permute(parallel_, rows_, source, entries_, moved);
}

template <class T>
void ContactMemory<T>::recall(const SlotLists& lists, WallLists<T>& walls,
                              const soa::Array<std::uint32_t>& rank) {
  collected_ = false;
  if (!law_.remembers()) return;
  touching_.resize(lists.slots());
  history_.resize(tasks_of(rows_, rows_per_task));
  for_groups(parallel_, rows_, [&](std::size_t task, std::size_t first, std::size_t last) {
    constexpr std::uint32_t nobody = ~std::uint32_t{0};
    std::vector<std::uint32_t> entries;   // of what is remembered, by slot and lane
    std::vector<std::uint32_t> contacts;  // of the task, in the order of the slots
    for (std::size_t group = first; group < last; ++group) {
      const std::size_t first_slot = lists.first_slot[group];
      const std::size_t slots = lists.first_slot[group + 1] - first_slot;
      std::fill_n(touching_.data() + first_slot, slots, std::uint16_t{0});
      entries.assign(slots * group_rows, nobody);
      for (std::size_t lane = 0; lane < group_rows; ++lane) {
        recall_row(lists, walls, rank.data(), group, lane, entries.data());
      }
      for_contacts(lists.first_slot, touching_, group, [&](std::size_t slot, std::size_t lane) {
        contacts.push_back(entries[(slot - first_slot) * group_rows + lane]);
      });
    }
    TaskHistory& history = history_[task];
    history.resize(contacts.size(), columns());
    for (std::size_t contact = 0; contact < contacts.size(); ++contact) {
      T* to = history.numbers.data() + contact;
      const std::size_t from = 3 * std::size_t{contacts[contact]};
      for (std::size_t c = 0; c < 3; ++c) {
        to[c * history.contacts] = tangential_[from + c];
        if (law_.rolls()) to[(3 + c) * history.contacts] = rolling_[from + c];
      }
    }
  });
}

// Marks the contacts of a row in the lists and says which entry of what is remembered is whose.
// Lists and memories both ascend.
template <class T>
void ContactMemory<T>::recall_row(const SlotLists& lists, WallLists<T>& walls,
                                  const std::uint32_t* rank, std::size_t group, std::size_t lane,
                                  std::uint32_t* entries) {
  const std::uint64_t first_slot = lists.first_slot[group];
  const std::uint64_t last_slot = lists.first_slot[group + 1];
  const std::uint64_t last_wall_slot = walls.first_slot[group + 1];
  std::uint64_t slot = first_slot;
  std::uint64_t wall_slot = walls.first_slot[group];
  const Entries own = entries_[group * group_rows + lane];
  const auto mark = [&](soa::Array<std::uint16_t>& touching, std::uint64_t at) {
    touching[at] = static_cast<std::uint16_t>(touching[at] | 1U << lane);
  };
  const auto rank_at = [&](std::uint64_t s) {
    const auto other = static_cast<std::size_t>(lists.neighbor[s * group_rows + lane]);
    return other == rows_ ? wall_flag : rank[other];
  };
  for (std::uint32_t entry = own.first; entry < own.last; ++entry) {
    const std::uint32_t partner = partner_[entry];
    if ((partner & wall_flag) == 0) {
      while (slot < last_slot && rank_at(slot) < partner) ++slot;
      if (slot == last_slot || rank_at(slot) != partner) continue;
      mark(touching_, slot);
      entries[(slot - first_slot) * group_rows + lane] = entry;
    } else {
      const std::uint32_t wall = partner & ~wall_flag;
      while (wall_slot < last_wall_slot && walls.part[wall_slot] < wall) ++wall_slot;
      if (wall_slot == last_wall_slot || walls.part[wall_slot] != wall) continue;
      if (walls.touching[wall_slot] == 0) walls.clear_slot(wall_slot, law_);
      mark(walls.touching, wall_slot);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t to = (wall_slot * 3 + c) * group_rows + lane;
        walls.tangential[to] = tangential_[3 * std::size_t{entry} + c];
        if (law_.rolls()) walls.rolling[to] = rolling_[3 * std::size_t{entry} + c];
      }
    }
  }
}

// ---- steps --------------------------------------------------------------------------------------

template <class T>
ContactHistory<T> ContactMemory<T>::history(std::size_t task, T* after, std::size_t room) {
  ContactHistory<T> history;
  if (!law_.remembers()) return history;
  history.touching = touching_.data();
  history.before = history_[task].numbers.data();
  history.count_before = history_[task].contacts;
  history.after = after;
  history.room = room;
  return history;
}

template <class T>
void ContactMemory<T>::take(std::size_t task, const ContactHistory<T>& stepped) {
  if (!law_.remembers()) return;
  TaskHistory& history = history_[task];
  history.resize(stepped.count, columns());
  for (std::size_t c = 0; c < columns(); ++c) {
    std::copy_n(stepped.after + c * stepped.room, stepped.count,
                history.numbers.data() + c * stepped.count);
  }
}

template class ContactMemory<float>;
template class ContactMemory<double>;

}  // namespace salvo::solver
