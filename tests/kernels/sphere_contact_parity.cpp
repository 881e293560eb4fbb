#include "tests/kernels/sphere_contact_parity.hpp"

#include "kernels/quads.hpp"
#include "kernels/sphere_contact.hpp"

namespace salvo::tests::sphere_contact_parity {
inline namespace SALVO_ISA {

namespace {

using kernels::Vec3;

template <class T>
void contact(const Run<T>& run) {
  using V = kernels::NativeLane<T>;
  for (std::size_t at = 0; at < run.rows; at += V::width) {
    const auto load = [&](const T* column) { return V::load(column + at); };
    const auto vector = [&](const T* const* c) -> Vec3<V> {
      return {load(c[0]), load(c[1]), load(c[2])};
    };
    std::size_t next = 0;
    const auto put = [&](V value) { value.store(run.result[next++] + at); };
    const auto put_vector = [&](const Vec3<V>& v) {
      put(v.x);
      put(v.y);
      put(v.z);
    };
    const V stiffness = load(run.stiffness);
    const V overlap = load(run.overlap);
    const V mass = load(run.mass);
    const V radius = load(run.radius);
    const V zeta = load(run.zeta);
    const V dt(run.dt);
    const auto both_sides = [&](const auto& law) {
      for (const bool partner : {false, true}) {
        const auto seen = [&](const Vec3<V>& v) { return partner ? -v : v; };
        const Vec3<V> normal = seen(vector(run.normal));
        const Vec3<V> velocity = seen(vector(run.velocity));
        const auto springs = law.at(overlap, {mass, radius, law.damping(mass, zeta)});
        const V apart = dot(velocity, normal);
        const auto force = kernels::normal_force(springs, apart, V(0.125) * radius);
        const Vec3<V> sliding = velocity - normal * apart;
        const kernels::SlipSpring<V> slip(seen(vector(run.displacement)), normal, sliding, springs,
                                          load(run.friction) * force.pressing, dt);
        put_vector(normal * force.along - slip.force);
        put_vector(slip.after);
        put(force.pressing);
        put((springs.elastic - force.pressing) * apart * dt);
        put(slip.work(sliding, dt));
        put(springs.normal_damping);
        put(law.elastic_energy(overlap, radius));
      }
    };
    both_sides(kernels::LinearSpring<V>{stiffness, stiffness * V(0.3), V(1) / (stiffness * V(0.3)),
                                        V(0.5)});
    both_sides(kernels::HertzMindlin<V>{stiffness, stiffness * V(0.7), V(0.5)});
  }
}

template <class T>
void quads(const Quads<T>& run) {
  using V = kernels::NativeLane<T>;
  for (std::size_t at = 0; at < run.rows; at += V::width) {
    const auto quad =
        kernels::load_quad<16>(run.from + 4, run.index + at, static_cast<const V*>(nullptr));
    for (std::size_t k = 0; k < 4; ++k) quad[k].store(run.loaded + k * run.rows + at);
    kernels::store_quad<16>(quad, run.stored + 16 * at + 8);
  }
}

}  // namespace

extern const Table test_table;
const Table test_table{&contact<float>, &contact<double>, &quads<float>, &quads<double>};

}  // namespace SALVO_ISA
}  // namespace salvo::tests::sphere_contact_parity
