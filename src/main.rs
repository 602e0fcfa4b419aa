fn main() -> std::process::ExitCode {
    terrane::app::main()
}
