// Every header in two units of one program: a function that is not inline, or a variable defined twice, ends at the
// linker. The answers are compared bit for bit.

double step_in_a(double dt);
double step_in_b(double dt);

int main() {
  const double a = step_in_a(0.125);
  const double b = step_in_b(0.125);
  return a > 0 && !(a < b) && !(b < a) ? 0 : 1;
}
