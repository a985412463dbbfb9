use sve_models::models::*;
use sve_runtime::prelude::*;
#[test]
fn show() {
    let s = TwoRods { m: [1.0, 0.5], l: [1.0, 0.7], g: 9.8, s: 0.3 };
    println!("{}", Integrator::new(&s, StormerVerlet).plan());
    println!("{}", Integrator::new(&s, Midpoint).plan());
    println!("{}", Integrator::new(&OnSphere{g:1.0,s:0.1}, Midpoint).plan());
    println!("{}", Integrator::new(&TurnedSphere{s:0.1}, Endpoint).plan());
}
